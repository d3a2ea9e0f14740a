//! The verbs for running applications, as users see them: real processes that find each other.

use std::io::{BufRead, BufReader, Read, Write};
use std::path::Path;
use std::process::{Child, Command, Stdio};

use jde_watchdog::Watchdog;
use serde_json::Value;
use tempfile::TempDir;

use crate::support::{Said, jde, jde_with_plugins, pair, plugins, root, said};

/// A folder in which the applications of one test find each other, and no others.
pub(crate) struct Place {
    folder: TempDir,
    _watchdog: Watchdog,
}

/// A running application. It is killed when dropped.
pub(crate) struct Running {
    process: Child,
}

impl Place {
    pub(crate) fn new() -> Self {
        Self {
            folder: tempfile::tempdir().expect("a folder"),
            _watchdog: Watchdog::for_test(),
        }
    }

    pub(crate) fn folder(&self) -> &Path {
        self.folder.path()
    }

    /// Starts an application, and returns once tools find it.
    pub(crate) fn start(&self, application: &str, more: &[&str]) -> Running {
        self.found(jde_with_plugins(&["run", application, "--plain"]), more)
    }

    /// Plays a recording, and returns once tools find it.
    pub(crate) fn replay(&self, file: &Path, more: &[&str]) -> Running {
        let mut command = jde(&["replay", "--plain"]);
        command.arg(file);
        self.found(command, more)
    }

    pub(crate) fn found(&self, command: Command, more: &[&str]) -> Running {
        let before = self.apps().len();
        let process = self
            .command(command)
            .args(more)
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .expect("the executable starts");
        let mut running = Running { process };
        while self.apps().len() == before {
            let ended = running.process.try_wait().expect("it can be asked");
            assert!(ended.is_none(), "it ended at once: {ended:?}");
        }
        running
    }

    pub(crate) fn command(&self, mut command: Command) -> Command {
        command
            .env("JDE_RUNTIME_DIR", self.folder.path().join("jde"))
            .env("XDG_STATE_HOME", self.folder.path())
            .env("USER", "ana")
            .env_remove("JDE_APP")
            .env_remove("JDE_AT")
            .current_dir(root());
        command
    }

    pub(crate) fn says(&self, args: &[&str]) -> Said {
        said(&mut self.command(jde(args)))
    }

    /// Runs a verb that must succeed, and returns its output.
    pub(crate) fn told(&self, args: &[&str]) -> String {
        let said = self.says(args);
        assert_eq!(said.status, Some(0), "jde {args:?}: {said:?}");
        said.out
    }

    pub(crate) fn json(&self, args: &[&str]) -> Value {
        let mut all = args.to_vec();
        all.push("--json");
        serde_json::from_str(self.told(&all).lines().last().expect("a line")).expect("JSON")
    }

    pub(crate) fn apps(&self) -> Vec<String> {
        let apps = self.json(&["apps"]);
        let names = apps.as_array().expect("a list").iter();
        names
            .map(|app| app["name"].as_str().expect("a name").to_owned())
            .collect()
    }

    /// Repeats a verb until its JSON is as wanted.
    pub(crate) fn until(&self, args: &[&str], wanted: impl Fn(&Value) -> bool) -> Value {
        loop {
            let answer = self.json(args);
            if wanted(&answer) {
                return answer;
            }
        }
    }
}

impl Running {
    pub(crate) fn signal(&self, name: &str) {
        let mut kill = Command::new("kill");
        kill.args([&format!("-{name}"), &self.process.id().to_string()]);
        assert!(kill.status().expect("there is a kill").success());
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        // It may have ended already.
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}

/// Starts a robot in the office, driven by four schemas.
pub(crate) fn navigation(place: &Place) -> Running {
    place.start("apps/safe-navigation.toml", &[])
}

pub(crate) fn schema<'s>(snapshot: &'s Value, name: &str) -> &'s Value {
    let mut schemas = snapshot["schemas"].as_array().expect("schemas").iter();
    schemas
        .find(|schema| schema["name"] == name)
        .expect("the schema is there")
}

#[test]
fn what_runs_is_listed_and_looked_into() {
    let place = Place::new();
    assert!(place.told(&["apps"]).contains("no application runs"));
    let _robot = navigation(&place);
    let apps = place.told(&["apps"]);
    assert!(
        apps.contains("safe-navigation") && apps.contains("ana@"),
        "{apps}"
    );
    let ps = place.told(&["ps"]);
    for part in ["[example/base]", "goon", "WINNER", "75 ms", "pioneer"] {
        assert!(ps.contains(part), "{part} in {ps}");
    }
    let vars = place.told(&["vars", "pioneer.*"]);
    assert!(
        vars.contains("sensor_msgs/LaserScan") && !vars.contains("goon."),
        "{vars}"
    );
    let goon = place.told(&["vars", "goon.*"]);
    assert!(goon.lines().any(|line| line.ends_with("  0.4 m/s")), "{goon}");
    let laser = vars
        .lines()
        .find(|line| line.contains("LaserScan"))
        .expect("it is listed");
    assert!(laser.ends_with('…'), "{laser}");
    let whole = place.json(&["vars", "pioneer.laser"]);
    assert!(
        whole[0]["value"]["ranges"]
            .as_array()
            .is_some_and(|ranges| ranges.len() > 90)
    );
    let number = place.told(&["get", "goon.fast"]);
    assert!(number.trim().ends_with("m/s"), "{number}");
    let pose = place.json(&["get", "pioneer.odometry.pose.pose.position"]);
    assert!(
        pose["value"]["x"].is_number() && pose["sequence"].as_u64() > Some(0),
        "{pose}"
    );
    let beam = place.json(&["get", "safe-navigation:pioneer.laser.ranges[90]"]);
    assert_eq!(beam["unit"], "m");
}

#[test]
fn names_that_are_none_are_answered_with_the_nearest() {
    let place = Place::new();
    let nothing = place.says(&["ps"]);
    assert_eq!(nothing.status, Some(1));
    assert!(nothing.err.contains("start one with `jde run`"), "{nothing:?}");
    let _robot = navigation(&place);
    for (args, near) in [
        (&["ps", "safe-navigatoin"][..], "did you mean `safe-navigation`?"),
        (&["get", "pioner.laser"], "did you mean `pioneer.laser`?"),
        (&["get", "pioneer.laser.rangs"], "did you mean `ranges`?"),
        (&["stop", "gon"], "did you mean `goon`?"),
        (&["set", "goon.fst", "1"], "did you mean `goon.fast`?"),
        (&["why", "vf"], "did you mean `vff`?"),
        (&["watch", "pioneer.odometr"], "did you mean `pioneer.odometry`?"),
    ] {
        let said = place.says(args);
        assert_eq!(said.status, Some(2), "{args:?}: {said:?}");
        assert!(said.err.contains(near), "{args:?}: {said:?}");
    }
}

#[test]
fn modulations_are_set_with_their_units_and_within_their_range() {
    let place = Place::new();
    let _robot = navigation(&place);
    place.told(&["set", "goon.fast", "30 cm/s"]);
    assert_eq!(place.json(&["get", "goon.fast"])["value"], 0.3);
    assert_eq!(place.json(&["get", "goon.fast"])["writer"], "operator");
    let held = schema(&place.json(&["ps"]), "goon")["operator"].clone();
    assert!(
        held["by"].as_str().is_some_and(|by| by.starts_with("ana@")),
        "{held}"
    );
    for (args, why) in [
        (&["set", "goon.fast", "30 deg"][..], "deg"),
        (&["set", "goon.fast", "-1 m/s"], "-1"),
        (&["set", "goon.fast", "quick"], "goon"),
        (&["set", "pioneer.laser", "1"], "no modulation"),
        (&["set", "goon.fast"], "no value"),
    ] {
        let said = place.says(args);
        assert_eq!(said.status, Some(2), "{args:?}: {said:?}");
        assert!(said.err.contains(why), "{args:?}: {said:?}");
    }
    assert_eq!(place.json(&["get", "goon.fast"])["value"], 0.3);
    place.told(&["release", "goon"]);
    place.until(&["get", "goon.fast"], |now| now["value"] != 0.3);
}

#[test]
fn r14_what_an_operator_does_is_shown_told_and_undone() {
    let place = Place::new();
    let _robot = navigation(&place);
    place.until(&["ps"], |now| schema(now, "goon")["state"] == "winner");
    place.told(&["stop", "goon"]);
    place.until(&["ps"], |now| schema(now, "goon")["state"] == "slept");
    let events = place.told(&["events", "--once"]);
    assert!(events.contains("ana@") && events.contains("goon"), "{events}");
    let why = place.told(&["why", "is", "goon", "not", "the", "winner"]);
    assert!(why.contains("example/base at"), "{why}");
    place.told(&["release", "goon"]);
    place.until(&["ps"], |now| schema(now, "goon")["state"] == "winner");
    // For a limited time.
    let held = place.told(&["force", "stop", "--for", "300ms"]);
    assert!(held.contains("is let go of"), "{held}");
    place.until(&["ps"], |now| schema(now, "stop")["operator"].is_null());
    place.told(&["period", "vff", "50ms"]);
    place.until(&["ps"], |now| schema(now, "vff")["period"] == 50_000_000);
    place.told(&["unload", "vff"]);
    place.until(&["ps"], |now| {
        schema(now, "vff")["operator"]["kind"] == "unloaded"
    });
    place.told(&["load", "vff"]);
    place.until(&["ps"], |now| schema(now, "vff")["state"] != "slept");
}

#[test]
fn r14_a_hold_ends_with_the_program_that_has_it() {
    let place = Place::new();
    let _robot = navigation(&place);
    let mut holder = place
        .command(jde(&["force", "stop", "--for", "10min"]))
        .stdout(Stdio::piped())
        .spawn()
        .expect("the executable starts");
    let mut line = String::new();
    BufReader::new(holder.stdout.take().unwrap())
        .read_line(&mut line)
        .unwrap();
    assert!(line.contains("is forced to win"), "{line}");
    place.until(&["ps"], |now| schema(now, "stop")["operator"]["kind"] == "forced");
    holder.kill().unwrap();
    holder.wait().unwrap();
    place.until(&["ps"], |now| schema(now, "stop")["operator"].is_null());
}

#[test]
fn values_are_watched_as_they_come() {
    let place = Place::new();
    let _robot = place.start(&pair(), &[]);
    let told = place.told(&["watch", "talker.count", "--count", "4", "--json"]);
    let lines: Vec<Value> = told
        .lines()
        .map(|line| serde_json::from_str(line).unwrap())
        .collect();
    let numbers: Vec<u64> = lines
        .iter()
        .map(|line| line["sequence"].as_u64().unwrap())
        .collect();
    assert_eq!(numbers.len(), 4);
    assert!(
        numbers.windows(2).all(|pair| pair[1] == pair[0] + 1),
        "{numbers:?}"
    );
    let slow = place.told(&["watch", "talker.count", "--count", "2", "--rate", "2"]);
    assert_eq!(slow.lines().count(), 2);
    let plot = place.says(&["watch", "talker.count", "--plot"]);
    assert_eq!(plot.status, Some(2));
    assert!(plot.err.contains("needs a terminal"), "{plot:?}");
}

#[test]
fn whoever_watches_is_told_that_the_application_is_gone() {
    let place = Place::new();
    let robot = place.start(&pair(), &[]);
    let mut watch = place
        .command(jde(&["watch", "talker.count"]))
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("the executable starts");
    let mut line = String::new();
    BufReader::new(watch.stdout.take().unwrap())
        .read_line(&mut line)
        .unwrap();
    robot.signal("KILL");
    let mut words = String::new();
    watch.stderr.take().unwrap().read_to_string(&mut words).unwrap();
    assert_eq!(watch.wait().unwrap().code(), Some(1));
    assert!(words.contains("`pair` is gone"), "{words}");
    // The killed application is no longer listed.
    assert!(place.apps().is_empty());
}

#[test]
fn several_applications_are_told_apart() {
    let place = Place::new();
    let _first = place.start(&pair(), &[]);
    let _second = place.start(&pair(), &[]);
    let _third = place.start(&pair(), &["--name", "robot3"]);
    let mut names = place.apps();
    names.sort_unstable();
    assert_eq!(names, ["pair", "pair-2", "robot3"]);
    let unclear = place.says(&["ps"]);
    assert_eq!(unclear.status, Some(2));
    for name in names {
        assert!(unclear.err.contains(&name), "{unclear:?}");
        place.told(&["ps", &name]);
        place.told(&["get", &format!("{name}:talker.count")]);
    }
    place.told(&["get", "talker.count", "--app", "robot3"]);
    let taken = said(
        place
            .command(jde_with_plugins(&["run", &pair(), "--plain", "--name", "robot3"]))
            .stdin(Stdio::null()),
    );
    assert_eq!(taken.status, Some(2));
    assert!(taken.err.contains("`robot3` already runs here"), "{taken:?}");
}

#[test]
fn a_shell_in_a_pipe_does_line_by_line_what_it_reads() {
    let place = Place::new();
    let _robot = navigation(&place);
    let mut shell = place
        .command(jde(&["shell"]))
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("the executable starts");
    let mut lines = shell.stdin.take().unwrap();
    lines
        .write_all(b"# slower\nuse safe-navigation\nset goon.fast '0.2 m/s'\nget goon.fast\nget gon.fast\nget goon.fast\n")
        .unwrap();
    drop(lines);
    let said = shell.wait_with_output().unwrap();
    let out = String::from_utf8(said.stdout).unwrap();
    let err = String::from_utf8(said.stderr).unwrap();
    assert_eq!(said.status.code(), Some(2), "{out}{err}");
    assert_eq!(out.lines().last(), Some("0.2 m/s"), "{out}{err}");
    assert_eq!(out.lines().count(), 2, "the first that fails ends it: {out}");
    assert!(err.contains("did you mean `goon.fast`?"), "{err}");
}

#[test]
fn the_oscilloscope_attaches_and_leaves_the_robot_running() {
    let place = Place::new();
    let _robot = navigation(&place);
    let command = format!("stty rows 30 cols 110; {} top", env!("CARGO_BIN_EXE_jde"));
    let mut script = Command::new("script");
    script
        .args(["-qec", &command, "/dev/null"])
        .env("TERM", "xterm-256color")
        .stdin(Stdio::piped())
        .stdout(Stdio::piped());
    let mut child = place
        .command(script)
        .spawn()
        .expect("script of util-linux is there");
    let (mut keys, mut screen) = (child.stdin.take().unwrap(), child.stdout.take().unwrap());
    let mut shown = Vec::new();
    let mut piece = [0; 4096];
    let mut left = false;
    loop {
        let length = screen.read(&mut piece).unwrap();
        if length == 0 {
            break;
        }
        shown.extend_from_slice(&piece[..length]);
        let text = String::from_utf8_lossy(&shown);
        if !left && text.contains("pioneer") && text.contains("WINNER") {
            keys.write_all(b"q").unwrap();
            left = true;
        }
    }
    assert_eq!(child.wait().unwrap().code(), Some(0));
    let shown = String::from_utf8_lossy(&shown);
    for part in ["safe-navigation", "example/base", "goon"] {
        assert!(shown.contains(part), "{part}");
    }
    assert_eq!(place.apps(), ["safe-navigation"]);
}

#[test]
fn shells_complete_the_names_in_what_runs() {
    let place = Place::new();
    let _robot = navigation(&place);
    let complete = |words: &[&str]| {
        let mut command = place.command(jde(&["--", "jde"]));
        command.args(words);
        command
            .env("COMPLETE", "bash")
            .env("_CLAP_COMPLETE_INDEX", words.len().to_string())
            .env("_CLAP_COMPLETE_COMP_TYPE", "9")
            .env("_CLAP_COMPLETE_SPACE", "false")
            .env("_CLAP_IFS", "\n");
        said(&mut command).out
    };
    assert!(complete(&["stop", "go"]).contains("goon"));
    assert!(complete(&["get", "pioneer.l"]).contains("pioneer.laser"));
    assert!(complete(&["ps", "safe"]).contains("safe-navigation"));
    assert!(complete(&["panel", "exa"]).contains("example"));
    assert!(complete(&["panel", "example", "--touch", "cl"]).contains("clear"));
    let script = place.told(&["completions", "bash"]);
    assert!(script.contains("COMPLETE") && script.contains("jde"), "{script}");
}

#[test]
fn a_run_can_be_closed_to_tools() {
    let place = Place::new();
    let mut quiet = place
        .command(jde_with_plugins(&["run", &pair(), "--plain", "--no-link"]))
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    let mut line = String::new();
    // Its first line shows that it runs.
    BufReader::new(quiet.stdout.take().unwrap())
        .read_line(&mut line)
        .unwrap();
    assert!(place.apps().is_empty());
    quiet.kill().unwrap();
    quiet.wait().unwrap();
    let _ = plugins();
}
