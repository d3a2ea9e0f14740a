//! The verbs that attach to running applications, tested with real processes.

use std::io::{BufRead, BufReader, Read, Write};
use std::path::Path;
use std::process::{Child, ChildStdout, Command, Stdio};

use jde_watchdog::Watchdog;
use serde_json::Value;
use tempfile::TempDir;

use crate::support::{RunOutput, jde, jde_with_plugins, output_of, pair, root, signal};
use crate::terminal::Terminal;

/// A runtime folder of one test. Only the applications that the test starts in it find each other.
pub(crate) struct Sandbox {
    folder: TempDir,
    _watchdog: Watchdog,
}

/// A running application. It is killed when dropped.
pub(crate) struct Running {
    process: Child,
}

impl Sandbox {
    pub(crate) fn new() -> Self {
        Self {
            folder: tempfile::tempdir().expect("a folder"),
            _watchdog: Watchdog::for_test(),
        }
    }

    pub(crate) fn folder(&self) -> &Path {
        self.folder.path()
    }

    /// Starts an application and waits until tools find it.
    pub(crate) fn start(&self, application: &str, options: &[&str]) -> Running {
        self.spawn(jde_with_plugins(&["run", application, "--plain"]), options)
    }

    /// Starts an application, and waits until a schema of it acts: it is the last of the list, in the order of their start.
    pub(crate) fn start_acting(&self, application: &str) -> Running {
        let running = self.start(application, &[]);
        self.until(&["apps"], |apps| {
            let newest = apps.as_array().and_then(|apps| apps.last()).expect("it runs");
            newest["acting"].as_array().is_some_and(|names| !names.is_empty())
        });
        running
    }

    /// Plays a recording and waits until tools find it.
    pub(crate) fn replay(&self, file: &Path, options: &[&str]) -> Running {
        let mut command = jde(&["replay", "--plain"]);
        command.arg(file);
        self.spawn(command, options)
    }

    /// Starts a process and waits until tools find its application.
    pub(crate) fn spawn(&self, mut command: Command, options: &[&str]) -> Running {
        command.args(options);
        self.spawn_printing(command, Stdio::null())
    }

    /// Starts a process that prints to `output`, and waits until tools find its application.
    pub(crate) fn spawn_printing(&self, command: Command, output: Stdio) -> Running {
        let before = self.apps().len();
        let process = self
            .command(command)
            .stdin(Stdio::null())
            .stdout(output)
            .stderr(Stdio::null())
            .spawn()
            .expect("the executable starts");
        let mut running = Running { process };
        while self.apps().len() == before {
            let ended = running.process.try_wait().expect("the process can be polled");
            assert!(ended.is_none(), "the process ended early: {ended:?}");
        }
        running
    }

    pub(crate) fn command(&self, mut command: Command) -> Command {
        command
            .env("JDE_RUNTIME_DIR", self.folder.path().join("jde"))
            .env("JDE_TEST_PROC", self.folder.path())
            .env("XDG_STATE_HOME", self.folder.path())
            .env("USER", "ana")
            .env_remove("JDE_APP")
            .env_remove("JDE_AT")
            .current_dir(root());
        command
    }

    /// Runs a verb.
    pub(crate) fn run(&self, args: &[&str]) -> RunOutput {
        output_of(&mut self.command(jde(args)))
    }

    /// Runs a verb that must succeed, and returns its standard output.
    pub(crate) fn run_ok(&self, args: &[&str]) -> String {
        let output = self.run(args);
        assert_eq!(output.status, Some(0), "jde {args:?}: {output:?}");
        output.out
    }

    /// Runs a verb with `--json`, and parses the last line of its output.
    pub(crate) fn json(&self, args: &[&str]) -> Value {
        let all = [args, &["--json"]].concat();
        serde_json::from_str(self.run_ok(&all).lines().last().expect("a line")).expect("JSON")
    }

    /// Returns the names of the motor schemas that are awake. Sensors stay awake when everything is stopped.
    pub(crate) fn motors_awake(&self) -> Vec<String> {
        let now = self.json(&["ps"]);
        let schemas = now["schemas"].as_array().expect("a list").iter();
        let awake = schemas.filter(|schema| schema["kind"] == "motor" && schema["state"] != "slept");
        awake.map(|schema| schema["name"].to_string()).collect()
    }

    /// Returns the names of the running applications.
    pub(crate) fn apps(&self) -> Vec<String> {
        let apps = self.json(&["apps"]);
        let names = apps.as_array().expect("a list").iter();
        names
            .map(|app| app["name"].as_str().expect("a name").to_owned())
            .collect()
    }

    /// Repeats a verb until its JSON fulfils a condition.
    pub(crate) fn until(&self, args: &[&str], condition: impl Fn(&Value) -> bool) -> Value {
        loop {
            let reply = self.json(args);
            if condition(&reply) {
                return reply;
            }
        }
    }
}

impl Running {
    /// Returns the reading end of its piped output, once.
    pub(crate) fn take_output(&mut self) -> Option<ChildStdout> {
        self.process.stdout.take()
    }

    pub(crate) fn id(&self) -> u32 {
        self.process.id()
    }

    /// Waits for its end. Returns its exit status; `None` if a signal ended it.
    pub(crate) fn wait(&mut self) -> Option<i32> {
        self.process.wait().expect("the process can be waited for").code()
    }

    pub(crate) fn signal(&self, name: &str) {
        signal(name, &self.process);
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        let _ = self.process.kill(); // It may have ended already.
        let _ = self.process.wait();
    }
}

/// Starts a robot in the office, driven by four schemas. Waits until one of them acts.
pub(crate) fn navigation(sandbox: &Sandbox) -> Running {
    sandbox.start_acting("apps/safe-navigation.toml")
}

pub(crate) fn schema<'s>(snapshot: &'s Value, name: &str) -> &'s Value {
    let mut schemas = snapshot["schemas"].as_array().expect("schemas").iter();
    schemas
        .find(|schema| schema["name"] == name)
        .expect("the schema is listed")
}

#[test]
fn apps_ps_vars_and_get_show_a_running_application() {
    let sandbox = Sandbox::new();
    assert!(sandbox.run_ok(&["apps"]).contains("no application runs"));
    let _robot = navigation(&sandbox);
    let apps = sandbox.run_ok(&["apps"]);
    assert!(
        apps.contains("safe-navigation") && apps.contains("ana@"),
        "{apps}"
    );
    let ps = sandbox.run_ok(&["ps"]);
    for part in ["[example/base]", "goon", "WINNER", "75 ms", "pioneer"] {
        assert!(ps.contains(part), "{part} in {ps}");
    }
    let vars = sandbox.run_ok(&["vars", "pioneer.*"]);
    assert!(
        vars.contains("sensor_msgs/LaserScan") && !vars.contains("goon."),
        "{vars}"
    );
    let goon = sandbox.run_ok(&["vars", "goon.*"]);
    assert!(goon.lines().any(|line| line.ends_with("  0.4 m/s")), "{goon}");
    let laser = vars
        .lines()
        .find(|line| line.contains("LaserScan"))
        .expect("the scan is listed");
    assert!(laser.ends_with('…'), "{laser}");
    let full = sandbox.json(&["vars", "pioneer.laser"]);
    assert!(
        full[0]["value"]["ranges"]
            .as_array()
            .is_some_and(|ranges| ranges.len() > 90)
    );
    let number = sandbox.run_ok(&["get", "goon.fast"]);
    assert!(number.trim().ends_with("m/s"), "{number}");
    let pose = sandbox.json(&["get", "pioneer.odometry.pose.pose.position"]);
    assert!(
        pose["value"]["x"].is_number() && pose["sequence"].as_u64() > Some(0),
        "{pose}"
    );
    let beam = sandbox.json(&["get", "safe-navigation:pioneer.laser.ranges[90]"]);
    assert_eq!(beam["unit"], "m");
}

#[test]
fn verbs_suggest_the_nearest_name_for_an_unknown_one() {
    let sandbox = Sandbox::new();
    let nothing = sandbox.run(&["ps"]);
    assert_eq!(nothing.status, Some(1));
    assert!(nothing.err.contains("start one with `jde run`"), "{nothing:?}");
    let _robot = navigation(&sandbox);
    for (args, suggestion) in [
        (&["ps", "safe-navigatoin"][..], "did you mean `safe-navigation`?"),
        (&["get", "pioner.laser"], "did you mean `pioneer.laser`?"),
        (&["get", "pioneer.laser.rangs"], "did you mean `ranges`?"),
        (&["stop", "gon"], "did you mean `goon`?"),
        (&["set", "goon.fst", "1"], "did you mean `goon.fast`?"),
        (&["get", "goon.nosuch"], "`goon` has goon."),
        (&["set", "goon.nosuch", "1"], "`goon` has goon.target, "),
        (&["why", "vf"], "did you mean `vff`?"),
        (&["watch", "pioneer.odometr"], "did you mean `pioneer.odometry`?"),
    ] {
        let output = sandbox.run(args);
        assert_eq!(output.status, Some(2), "{args:?}: {output:?}");
        assert!(output.err.contains(suggestion), "{args:?}: {output:?}");
    }
}

#[test]
fn set_names_the_present_name_of_a_modulation_that_was_renamed() {
    let sandbox = Sandbox::new();
    let _robot = sandbox.start("apps/wander.toml", &[]);
    let renamed = sandbox.run(&["set", "wander.fast", "0.3"]);
    assert_eq!(renamed.status, Some(2), "{renamed:?}");
    assert!(
        renamed
            .err
            .contains("`wander.fast` is called `wander.vx_max` now"),
        "{renamed:?}"
    );
}

#[test]
fn the_meaning_of_a_variable_is_printed_in_full() {
    let sandbox = Sandbox::new();
    let _robot = navigation(&sandbox);
    let docs = sandbox.run_ok(&["vars", "vff.*", "--docs"]);
    assert!(docs.contains("at the area's edge; the father must"), "{docs}");
    let panels = sandbox.run_ok(&["panel"]);
    assert!(panels.lines().all(|line| line.ends_with('.')), "{panels}");
}

#[test]
fn set_accepts_values_with_units_and_only_within_the_range() {
    let sandbox = Sandbox::new();
    let _robot = navigation(&sandbox);
    sandbox.run_ok(&["set", "goon.fast", "30 cm/s"]);
    assert_eq!(sandbox.json(&["get", "goon.fast"])["value"], 0.3);
    assert_eq!(sandbox.json(&["get", "goon.fast"])["writer"], "operator");
    let operator = schema(&sandbox.json(&["ps"]), "goon")["operator"].clone();
    assert!(
        operator["by"].as_str().is_some_and(|by| by.starts_with("ana@")),
        "{operator}"
    );
    for (args, reason) in [
        (&["set", "goon.fast", "30 deg"][..], "deg"),
        (&["set", "goon.fast", "-1 m/s"], "-1"),
        (&["set", "goon.fast", "quick"], "goon"),
        (&["set", "pioneer.laser", "1"], "not a modulation"),
        (&["set", "goon.fast"], "no value"),
    ] {
        let output = sandbox.run(args);
        assert_eq!(output.status, Some(2), "{args:?}: {output:?}");
        assert!(output.err.contains(reason), "{args:?}: {output:?}");
    }
    assert_eq!(sandbox.json(&["get", "goon.fast"])["value"], 0.3);
    sandbox.run_ok(&["release", "goon"]);
    sandbox.until(&["get", "goon.fast"], |now| now["value"] != 0.3);
}

#[test]
fn r14_actions_of_an_operator_are_shown_recorded_as_events_and_released() {
    let sandbox = Sandbox::new();
    let _robot = navigation(&sandbox);
    sandbox.until(&["ps"], |now| schema(now, "goon")["state"] == "winner");
    sandbox.run_ok(&["stop", "goon"]);
    sandbox.until(&["ps"], |now| schema(now, "goon")["state"] == "slept");
    let events = sandbox.run_ok(&["events", "--once"]);
    assert!(events.contains("ana@") && events.contains("goon"), "{events}");
    let why = sandbox.run_ok(&["why", "is", "goon", "not", "the", "winner"]);
    assert!(why.contains("example/base at"), "{why}");
    sandbox.run_ok(&["release", "goon"]);
    sandbox.until(&["ps"], |now| schema(now, "goon")["state"] == "winner");
    let forced = sandbox.run_ok(&["force", "stop", "--for", "300ms"]);
    assert!(forced.contains("is released"), "{forced}");
    sandbox.until(&["ps"], |now| schema(now, "stop")["operator"].is_null());
    sandbox.run_ok(&["period", "vff", "50ms"]);
    sandbox.until(&["ps"], |now| schema(now, "vff")["period"] == 50_000_000);
    sandbox.run_ok(&["unload", "vff"]);
    sandbox.until(&["ps"], |now| {
        schema(now, "vff")["operator"]["kind"] == "unloaded"
    });
    sandbox.run_ok(&["load", "vff"]);
    sandbox.until(&["ps"], |now| schema(now, "vff")["state"] != "slept");
}

#[test]
fn r14_a_forced_state_ends_when_the_program_that_holds_it_is_killed() {
    let sandbox = Sandbox::new();
    let _robot = navigation(&sandbox);
    let mut holder = sandbox
        .command(jde(&["force", "stop", "--for", "10min"]))
        .stdout(Stdio::piped())
        .spawn()
        .expect("the executable starts");
    let mut line = String::new();
    BufReader::new(holder.stdout.take().unwrap())
        .read_line(&mut line)
        .unwrap();
    assert!(line.contains("is forced to win"), "{line}");
    sandbox.until(&["ps"], |now| schema(now, "stop")["operator"]["kind"] == "forced");
    holder.kill().unwrap();
    holder.wait().unwrap();
    sandbox.until(&["ps"], |now| schema(now, "stop")["operator"].is_null());
}

#[test]
fn watch_prints_each_new_value_unless_its_rate_is_limited() {
    let sandbox = Sandbox::new();
    let _robot = sandbox.start(&pair(), &[]);
    let output = sandbox.run_ok(&["watch", "talker.count", "--count", "4", "--json"]);
    let lines: Vec<Value> = output
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
    let slow = sandbox.run_ok(&["watch", "talker.count", "--count", "2", "--rate", "2"]);
    assert_eq!(slow.lines().count(), 2);
    let plot = sandbox.run(&["watch", "talker.count", "--plot"]);
    assert_eq!(plot.status, Some(2));
    assert!(plot.err.contains("needs a terminal"), "{plot:?}");
}

#[test]
fn watch_fails_when_its_application_is_killed() {
    let sandbox = Sandbox::new();
    let robot = sandbox.start(&pair(), &[]);
    let mut watch = sandbox
        .command(jde(&["watch", "talker.count"]))
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("the executable starts");
    // `watch` ends with status 0 if its output is closed.
    let mut values = BufReader::new(watch.stdout.take().unwrap());
    values.read_line(&mut String::new()).unwrap();
    robot.signal("KILL");
    let mut errors = String::new();
    watch.stderr.take().unwrap().read_to_string(&mut errors).unwrap();
    assert_eq!(watch.wait().unwrap().code(), Some(1));
    assert!(errors.contains("`pair` is gone"), "{errors}");
    assert!(sandbox.apps().is_empty());
}

#[test]
fn several_applications_have_different_names_and_a_verb_needs_one_of_them() {
    let sandbox = Sandbox::new();
    let _first = sandbox.start(&pair(), &[]);
    let _second = sandbox.start(&pair(), &[]);
    let _third = sandbox.start(&pair(), &["--name", "robot3"]);
    let mut names = sandbox.apps();
    names.sort_unstable();
    assert_eq!(names, ["pair", "pair-2", "robot3"]);
    let ambiguous = sandbox.run(&["ps"]);
    assert_eq!(ambiguous.status, Some(2));
    for name in names {
        assert!(ambiguous.err.contains(&name), "{ambiguous:?}");
        sandbox.run_ok(&["ps", &name]);
        sandbox.run_ok(&["get", &format!("{name}:talker.count")]);
    }
    sandbox.run_ok(&["get", "talker.count", "--app", "robot3"]);
    let taken = output_of(
        sandbox
            .command(jde_with_plugins(&["run", &pair(), "--plain", "--name", "robot3"]))
            .stdin(Stdio::null()),
    );
    assert_eq!(taken.status, Some(2));
    assert!(taken.err.contains("`robot3` already runs here"), "{taken:?}");
}

#[test]
fn a_shell_in_a_pipe_runs_each_line_and_ends_at_the_first_error() {
    let sandbox = Sandbox::new();
    let _robot = navigation(&sandbox);
    let mut shell = sandbox
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
    let output = shell.wait_with_output().unwrap();
    let out = String::from_utf8(output.stdout).unwrap();
    let err = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(2), "{out}{err}");
    assert_eq!(out.lines().last(), Some("0.2 m/s"), "{out}{err}");
    assert_eq!(out.lines().count(), 2, "the shell ends at the first error: {out}");
    assert!(err.contains("did you mean `goon.fast`?"), "{err}");
}

#[test]
fn top_attaches_to_a_robot_that_keeps_running_when_top_ends() {
    let sandbox = Sandbox::new();
    let _robot = navigation(&sandbox);
    let mut terminal = Terminal::start(&sandbox, [30, 110], &format!("{} top", env!("CARGO_BIN_EXE_jde")));
    terminal.wait_for(|shown| shown.contains("pioneer") && shown.contains("WINNER"));
    terminal.type_keys(b"q");
    let (status, shown) = terminal.finish();
    assert_eq!(status, Some(0), "{shown}");
    for part in ["safe-navigation", "example/base", "goon"] {
        assert!(shown.contains(part), "{part}");
    }
    assert_eq!(sandbox.apps(), ["safe-navigation"]);
}

#[test]
fn completions_offer_the_names_of_running_applications() {
    let sandbox = Sandbox::new();
    let _robot = navigation(&sandbox);
    let completed = |arguments: &[&str]| {
        let mut command = sandbox.command(jde(&["--", "jde"]));
        command.args(arguments);
        command
            .env("COMPLETE", "bash")
            .env("_CLAP_COMPLETE_INDEX", arguments.len().to_string())
            .env("_CLAP_COMPLETE_COMP_TYPE", "9")
            .env("_CLAP_COMPLETE_SPACE", "false")
            .env("_CLAP_IFS", "\n");
        output_of(&mut command).out
    };
    // A shell does not wait for a robot that is busy: a completion is empty then, and the next one is not.
    let offers = |arguments: &[&str], expected: &str| while !completed(arguments).contains(expected) {};
    offers(&["stop", "go"], "goon");
    offers(&["get", "pioneer.l"], "pioneer.laser");
    offers(&["ps", "safe"], "safe-navigation");
    offers(&["panel", "exa"], "example");
    offers(&["panel", "example", "--touch", "cl"], "clear");
    let script = sandbox.run_ok(&["completions", "bash"]);
    assert!(script.contains("COMPLETE") && script.contains("jde"), "{script}");
}

#[test]
fn a_run_without_link_is_invisible_to_tools() {
    let sandbox = Sandbox::new();
    let mut run = sandbox
        .command(jde_with_plugins(&["run", &pair(), "--plain", "--no-link"]))
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    let mut line = String::new();
    BufReader::new(run.stdout.take().unwrap())
        .read_line(&mut line)
        .unwrap();
    assert!(sandbox.apps().is_empty());
    run.kill().unwrap();
    run.wait().unwrap();
}
