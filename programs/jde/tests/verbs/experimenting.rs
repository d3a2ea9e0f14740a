//! `jde experiment` and `jde test`: many drives in processes of their own, and what remains when one of them
//! dies.

use std::fs;
use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Child, Command, Stdio};

use jde_watchdog::Watchdog;
use serde_json::Value;

use crate::support::{RunOutput, jde_with_plugins, json, output_of, root, signal};

/// Two axes of a toy whose listener takes over repeatedly: 12 drives of two seconds.
const PAIR: &str = r#"
application = "APPLICATION"
for = "2s"

[axes]
seeds = "1..6"
set."talker.period" = ["50ms", "100ms"]

[must."the listener wins"]
eventually = "listener.won"

[measure]
time = "time"
won  = { share = "listener.won" }
"#;

/// A motor schema that misbehaves in a different way in each drive. With one job, each drive has the process of the one
/// before if that lives.
const FAULTS: &str = r#"
application = "app.toml"
for = "1s"

[axes]
set."mover.trouble" = ["", "segfault", "abort", "exit", "eat", "hang", "fork", "leave", "double", "abort"]

[must."it moves"]
eventually = "axis.beats > 10u"
"#;

const FAULTY: &str = r#"
roots = ["mover"]

[schemas.axis]
type = "fault/device"

[schemas.mover]
type      = "fault/motor"
actuators = { base = "axis.velocity" }
"#;

/// Writes the experiment of the toy into a folder.
pub(crate) fn pair(folder: &Path) {
    let application = root().join("apps/pair.toml").display().to_string();
    fs::write(
        folder.join("pair.toml"),
        PAIR.replace("APPLICATION", &application),
    )
    .unwrap();
}

pub(crate) fn experiment(folder: &Path, args: &[&str]) -> RunOutput {
    let args = [&["experiment"], args].concat();
    output_of(jde_with_plugins(&args).current_dir(folder))
}

/// Returns the content of each file of results.
fn results(folder: &Path) -> Vec<String> {
    let files = ["results.jsonl", "results.csv", "junit.xml"];
    files
        .map(|file| fs::read_to_string(folder.join(file)).expect("the file is written"))
        .to_vec()
}

pub(crate) fn lines(folder: &Path) -> Vec<Value> {
    let text = fs::read_to_string(folder.join("results.jsonl")).unwrap();
    text.lines()
        .map(|line| serde_json::from_str(line).unwrap())
        .collect()
}

#[test]
fn a_step_may_use_the_former_name_of_a_parameter() {
    let folder = tempfile::tempdir().unwrap();
    let application = root().join("apps/wander.toml");
    let text = format!(
        r#"
application = {application:?}
for = "1s"

[[steps]]
at  = "500ms"
set = {{ "wander.fast" = 0.1 }}

[measure]
slow = {{ last = "wander.vx_max" }}
"#
    );
    fs::write(folder.path().join("slow.toml"), text).unwrap();
    let run = experiment(folder.path(), &["slow.toml", "--out", "out"]);
    assert_eq!(run.status, Some(0), "{run:?}");
    assert!(run.err.contains("is now called `vx_max`"), "{run:?}");
    let [_, csv, _] = &results(&folder.path().join("out"))[..] else {
        panic!("there are three files of results");
    };
    assert!(csv.contains(",0.1"), "{csv}");
}

#[test]
fn results_do_not_depend_on_the_number_of_jobs_and_are_in_order() {
    let folder = tempfile::tempdir().unwrap();
    pair(folder.path());
    for jobs in ["1", "3"] {
        let run = experiment(
            folder.path(),
            &["pair.toml", "--out", jobs, "--jobs", jobs, "--json"],
        );
        assert_eq!(run.status, Some(0), "{}", run.err);
        assert_eq!(json(&run.out)["passed"], 12);
        assert!(!run.err.contains('\u{1b}'), "no colours in a pipe: {}", run.err);
    }
    let of = |jobs: &str| results(&folder.path().join(jobs));
    assert_eq!(of("1"), of("3"));
    let lines = lines(&folder.path().join("1"));
    let drives: Vec<_> = lines.iter().map(|line| line["drive"].as_u64().unwrap()).collect();
    assert_eq!(drives, (0..12).collect::<Vec<_>>());
    assert_eq!(lines[3]["seed"], 2);
    assert_eq!(lines[3]["talker.period"], "100ms");
    assert_eq!(lines[3]["time"], 2.0);
}

#[test]
fn a_step_of_a_case_acts_in_it_alone_and_the_seed_may_state_when() {
    let folder = tempfile::tempdir().unwrap();
    let application = root().join("apps/pair.toml").display().to_string();
    let text = format!(
        "application = \"{application}\"\nfor = \"2s\"\n\
         axes.seeds = [3, 9]\n\
         cases = [{{ name = \"stopped\" }}, {{ name = \"free\" }}]\n\
         steps = [{{ case = \"stopped\", when = \"time >= 0.1 * seed\", stop = \"listener\" }}]\n\
         measure.acts = {{ integral = \"listener.won ? 1.0 : 0.0\" }}\n"
    );
    fs::write(folder.path().join("cases.toml"), text).unwrap();
    let run = experiment(folder.path(), &["cases.toml", "--out", "results"]);
    assert_eq!(run.status, Some(0), "{}", run.err);
    let acts = |line: &Value| (line["acts"].as_f64().unwrap() * 10.0).round() / 10.0;
    let drives: Vec<_> = lines(&folder.path().join("results")).iter().map(acts).collect();
    assert!(
        drives[0] < 0.5 && drives[1] > 0.7 && drives[1] < 1.0,
        "{drives:?}"
    );
    assert!(drives[2] > 1.5 && drives[3] > 1.5, "{drives:?}");
}

#[test]
fn the_parts_of_an_experiment_are_joined_to_the_results_of_the_whole() {
    let folder = tempfile::tempdir().unwrap();
    pair(folder.path());
    experiment(folder.path(), &["pair.toml", "--out", "whole"]);
    for part in ["1", "2", "3"] {
        let shard = format!("{part}/3");
        let run = experiment(folder.path(), &["pair.toml", "--out", part, "--shard", &shard]);
        assert_eq!(run.status, Some(0), "{}", run.err);
    }
    let incomplete = experiment(folder.path(), &["merge", "1", "3", "--out", "two"]);
    assert_eq!(incomplete.status, Some(1));
    assert!(
        incomplete.err.contains("4 drives are in none of"),
        "{}",
        incomplete.err
    );
    let merged = experiment(folder.path(), &["merge", "3", "1", "2", "--out", "merged"]);
    assert_eq!(merged.status, Some(0), "{}", merged.err);
    assert_eq!(
        results(&folder.path().join("merged")),
        results(&folder.path().join("whole"))
    );
}

#[test]
fn a_drive_that_kills_or_blocks_its_process_is_a_result_and_the_others_go_on() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("app.toml"), FAULTY).unwrap();
    fs::write(folder.path().join("faults.toml"), FAULTS).unwrap();
    let args = [
        "faults.toml",
        "--out",
        "out",
        "--limit",
        "10s",
        "--memory",
        "1GB",
        "--jobs",
        "1",
    ];
    let run = experiment(folder.path(), &args);
    assert_eq!(run.status, Some(1), "{}", run.err);
    let lines = lines(&folder.path().join("out"));
    let outcomes: Vec<_> = lines
        .iter()
        .map(|line| line["outcome"].as_str().unwrap())
        .collect();
    assert_eq!(
        outcomes,
        [
            "passed", "crashed", "crashed", "crashed", "crashed", "hung", "crashed", "crashed", "passed",
            "crashed"
        ]
    );
    let why = |drive: usize| lines[drive]["why"].as_str().unwrap();
    assert!(why(1).contains("signal 11"), "{}", why(1));
    assert!(why(2).contains("signal 6"), "{}", why(2));
    assert!(why(3).contains("exited with status 3"), "{}", why(3));
    assert!(why(4).contains("memory allocation"), "{}", why(4));
    assert!(why(5).contains("longer than 10 s"), "{}", why(5));
    // It has left a process behind that holds its streams.
    assert!(why(6).contains("signal 6"), "{}", why(6));
    // The process that goes on in its place does not answer for it.
    assert!(why(7).contains("signal 6"), "{}", why(7));
    let drives: Vec<_> = lines.iter().map(|line| line["drive"].as_u64().unwrap()).collect();
    assert_eq!(drives, (0..10).collect::<Vec<_>>(), "each has one result");
    assert_eq!(lines[1]["it moves"], Value::Null, "it was not judged");
}

#[test]
fn an_interrupted_experiment_keeps_its_results_and_goes_on() {
    let _watchdog = Watchdog::for_test();
    let folder = tempfile::tempdir().unwrap();
    pair(folder.path());
    // A thousand drives of a second job: enough that the interruption comes before the end.
    let text = fs::read_to_string(folder.path().join("pair.toml")).unwrap();
    fs::write(folder.path().join("pair.toml"), text.replace("1..6", "1..300")).unwrap();
    let mut command = jde_with_plugins(&["experiment", "pair.toml", "--out", "out", "--jobs", "1"]);
    let mut child = command
        .current_dir(folder.path())
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    wait_for_a_line(&folder.path().join("out/results.jsonl"));
    signal("INT", &child);
    let error = read_to_end(&mut child);
    assert_eq!(child.wait().unwrap().code(), Some(1), "{error}");
    assert!(error.contains("--resume"), "{error}");
    let kept = lines(&folder.path().join("out")).len();
    assert!((1..600).contains(&kept), "{kept} drives");

    let again = experiment(folder.path(), &["pair.toml", "--out", "out"]);
    assert_eq!(again.status, Some(2), "the folder is not free");
    let resumed = experiment(folder.path(), &["pair.toml", "--out", "out", "--resume"]);
    assert_eq!(resumed.status, Some(0), "{}", resumed.err);
    assert_eq!(lines(&folder.path().join("out")).len(), 600);

    fs::write(folder.path().join("pair.toml"), text).unwrap();
    let other = experiment(folder.path(), &["pair.toml", "--out", "out", "--resume"]);
    assert_eq!(other.status, Some(2), "another experiment");
    assert!(other.err.contains("another experiment"), "{}", other.err);
}

#[test]
fn a_signal_to_all_processes_of_an_experiment_stops_it_and_is_no_result() {
    let _watchdog = Watchdog::for_test();
    let folder = tempfile::tempdir().unwrap();
    pair(folder.path());
    let text = fs::read_to_string(folder.path().join("pair.toml")).unwrap();
    fs::write(folder.path().join("pair.toml"), text.replace("1..6", "1..300")).unwrap();
    let mut child = jde_with_plugins(&["experiment", "pair.toml", "--out", "out", "--jobs", "2"])
        .current_dir(folder.path())
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    wait_for_a_line(&folder.path().join("out/results.jsonl"));
    let mut all = Command::new("kill");
    all.arg("-TERM")
        .args(children(child.id()))
        .arg(child.id().to_string());
    assert!(all.status().unwrap().success());
    assert_eq!(child.wait().unwrap().code(), Some(1));
    let lines = lines(&folder.path().join("out"));
    assert!((1..600).contains(&lines.len()), "{} drives", lines.len());
    for line in lines {
        assert_eq!(line["outcome"], "passed", "{line}");
    }
}

#[test]
fn an_experiment_that_was_killed_before_its_first_result_is_resumed() {
    let folder = tempfile::tempdir().unwrap();
    pair(folder.path());
    experiment(folder.path(), &["pair.toml", "--out", "out"]);
    fs::remove_file(folder.path().join("out/results.jsonl")).unwrap();
    let resumed = experiment(folder.path(), &["pair.toml", "--out", "out", "--resume"]);
    assert_eq!(resumed.status, Some(0), "{}", resumed.err);
    assert_eq!(lines(&folder.path().join("out")).len(), 12);
}

#[test]
fn one_drive_again_gives_its_result_and_a_recording() {
    let folder = tempfile::tempdir().unwrap();
    pair(folder.path());
    experiment(folder.path(), &["pair.toml", "--out", "out"]);
    let args = ["pair.toml", "--drive", "5", "--record", "drive.mcap", "--json"];
    let run = experiment(folder.path(), &args);
    assert_eq!(run.status, Some(0), "{}", run.err);
    assert_eq!(json(&run.out), lines(&folder.path().join("out"))[5]);
    let info = output_of(jde_with_plugins(&["info", "drive.mcap", "--json"]).current_dir(&folder));
    assert_eq!(info.status, Some(0), "{}", info.err);
    let missing = experiment(folder.path(), &["pair.toml", "--drive", "12"]);
    assert_eq!(missing.status, Some(2));
    assert!(missing.err.contains("12 drives, from 0"), "{}", missing.err);
}

#[test]
fn all_faults_of_an_experiment_are_reported_at_once_with_their_lines() {
    let folder = tempfile::tempdir().unwrap();
    let application = root().join("apps/pair.toml").display().to_string();
    let text = format!(
        "application = \"{application}\"\n\
         for = \"60 apples\"\n\
         [axes]\n\
         seeds = \"5..1\"\n\
         set.\"talker.perod\" = [1]\n\
         [must.\"a\"]\n\
         never = \"listner.won\"\n\
         [must.\"b\"]\n\
         nevr = \"listener.won\"\n\
         [measure]\n\
         seconds = \"time\"\n\
         [[steps]]\n\
         at = 5\n\
         stop = \"lisener\"\n\
         [[steps]]\n\
         case = \"bright\"\n\
         at = 5\n\
         stop = \"listener\"\n\
         [[cases]]\n\
         name = \"dark\"\n"
    );
    fs::write(folder.path().join("wrong.toml"), text).unwrap();
    let run = experiment(folder.path(), &["wrong.toml"]);
    assert_eq!(run.status, Some(2));
    for line in ["2:7", "4:9", "5:23", "7:10", "9:1", "11:11", "14:8", "16:8"] {
        assert!(
            run.err.contains(&format!("wrong.toml:{line}")),
            "{line}: {}",
            run.err
        );
    }
    for name in ["`listener.won`", "`period`", "`never`", "`listener`"] {
        assert!(
            run.err.contains(&format!("did you mean {name}")),
            "{name}: {}",
            run.err
        );
    }
    assert!(!folder.path().join("results").exists(), "nothing is written");
}

#[test]
fn the_worlds_of_a_folder_are_an_axis_and_may_state_the_length_of_their_reference_path() {
    let folder = tempfile::tempdir().unwrap();
    let worlds = folder.path().join("worlds");
    fs::create_dir(&worlds).unwrap();
    let world = "robots.robot.start = { x = 0, y = 0 }\nwalls = [{ points = [[2, -1], [2, 1]] }]\n";
    fs::write(worlds.join("b.toml"), world).unwrap();
    fs::write(worlds.join("a.toml"), format!("reference_length = 0.2\n{world}")).unwrap();
    fs::write(worlds.join("notes.txt"), "no world").unwrap();
    let application = "[schemas.robot]\ntype = \"sim/robot\"\nworld = \"worlds/a.toml\"\n\
                       [schemas.mover]\ntype = \"fault/motor\"\nactuators = { base = \"robot.velocity\" }\n";
    fs::write(
        folder.path().join("app.toml"),
        format!("roots = [\"mover\"]\n{application}"),
    )
    .unwrap();
    let experiment_file = folder.path().join("worlds.toml");
    let text = "application = \"app.toml\"\nfor = \"1s\"\naxes.worlds = [\"worlds\"]\n\
                must.free.never = \"collisions > 0\"\nmeasure.score = \"barn\"\n";
    fs::write(&experiment_file, text).unwrap();
    let run = experiment(folder.path(), &["worlds.toml", "--out", "results", "--jobs", "1"]);
    assert_eq!(run.status, Some(0), "{}", run.err);
    let drives = lines(&folder.path().join("results"));
    let column = |key: &str| -> Vec<_> { drives.iter().map(|drive| drive[key].clone()).collect() };
    assert_eq!(column("world"), ["worlds/a.toml", "worlds/b.toml"]);
    // It stands for 1 s, and eight optimal times are 0.8 s. Without a mission there is no direct length.
    assert_eq!(column("score"), [Value::from(0.125), Value::Null]);

    fs::write(&experiment_file, text.replace("[\"worlds\"]", "[\"empty\"]")).unwrap();
    fs::create_dir(folder.path().join("empty")).unwrap();
    let refused = experiment(folder.path(), &["worlds.toml"]);
    assert_eq!(refused.status, Some(2));
    assert!(refused.err.contains("worlds.toml:3:"), "{}", refused.err);
    assert!(refused.err.contains("has no world"), "{}", refused.err);

    fs::write(&experiment_file, text.replace("[\"worlds\"]", "[\"loop\"]")).unwrap();
    std::os::unix::fs::symlink("loop", folder.path().join("loop")).unwrap();
    let unreadable = experiment(folder.path(), &["worlds.toml"]);
    assert_eq!(unreadable.status, Some(2));
    for part in ["worlds.toml:3:", "cannot read the folder", "symbolic links"] {
        assert!(unreadable.err.contains(part), "{}", unreadable.err);
    }
}

#[test]
fn a_new_application_passes_its_tests_and_a_failure_explains_itself() {
    let folder = tempfile::tempdir().unwrap();
    let new = output_of(jde_with_plugins(&["new", "app", "patrol"]).current_dir(&folder));
    assert_eq!(new.status, Some(0), "{}", new.err);
    let patrol = folder.path().join("patrol");
    let test = |args: &[&str]| output_of(jde_with_plugins(&[&["test"], args].concat()).current_dir(&patrol));
    let passed = test(&["--json"]);
    assert_eq!(passed.status, Some(0), "{}{}", passed.out, passed.err);
    assert_eq!(json(&passed.out)["passed"], 2);
    let shuffled = test(&["--shuffle=7", "--filter", "reaches"]);
    assert!(
        shuffled.out.starts_with("1 test, --shuffle=7"),
        "{}",
        shuffled.out
    );

    let file = patrol.join("tests/stops-before-a-box.toml");
    let text = fs::read_to_string(&file).unwrap();
    fs::write(&file, text.replace("collisions > 0", "clearance < 0.4")).unwrap();
    let failed = test(&["--filter", "box"]);
    assert_eq!(failed.status, Some(1));
    for part in [
        "0 passed, 1 failed",
        "`clearance < 0.4` is true at",
        "-> vff",
        "--drive 0 --record",
    ] {
        assert!(failed.out.contains(part), "{part}: {}", failed.out);
    }
    let none = test(&["--filter", "zzz"]);
    assert_eq!((none.status, none.err.contains("there are: ")), (Some(2), true));
    let none = output_of(jde_with_plugins(&["test"]).current_dir(&folder));
    assert_eq!(none.status, Some(2), "{}", none.err);
    assert!(none.err.contains("there is no test in tests"), "{}", none.err);
}

#[test]
fn watched_tests_run_again_after_a_change() {
    let _watchdog = Watchdog::for_test();
    let folder = tempfile::tempdir().unwrap();
    output_of(jde_with_plugins(&["new", "app", "patrol"]).current_dir(&folder));
    let patrol = folder.path().join("patrol");
    let mut child = jde_with_plugins(&["test", "--watch", "--filter", "box"])
        .current_dir(&patrol)
        .stdout(Stdio::piped())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    let mut output = BufReader::new(child.stdout.take().unwrap()).lines();
    let mut until = |part: &str| output.find(|line| line.as_ref().is_ok_and(|line| line.contains(part)));
    assert!(until("1 passed").is_some());
    let file = patrol.join("tests/stops-before-a-box.toml");
    let text = fs::read_to_string(&file).unwrap();
    fs::write(&file, text.replace("collisions > 0", "clearance < 0.4")).unwrap();
    assert!(until("1 failed").is_some());
    signal("INT", &child);
    child.wait().unwrap();
}

/// Waits until a file has a complete line.
fn wait_for_a_line(file: &Path) {
    while !fs::read_to_string(file).is_ok_and(|text| text.contains('\n')) {
        std::thread::yield_now();
    }
}

/// Returns the processes that this one has started.
fn children(process: u32) -> Vec<String> {
    let threads = fs::read_dir(format!("/proc/{process}/task")).unwrap();
    let of_thread =
        |thread: fs::DirEntry| fs::read_to_string(thread.path().join("children")).unwrap_or_default();
    threads
        .flat_map(|thread| {
            of_thread(thread.unwrap())
                .split_whitespace()
                .map(str::to_owned)
                .collect::<Vec<_>>()
        })
        .collect()
}

fn read_to_end(child: &mut Child) -> String {
    std::io::read_to_string(child.stderr.take().unwrap()).unwrap()
}
