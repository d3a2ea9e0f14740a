//! Short campaigns from the command line: applications survive the faults, the observer finds violations, and
//! a failure names the command that repeats it.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::sync::OnceLock;

/// The plugins of the applications of the campaign.
const PLUGINS: [&str; 8] = [
    "fault", "sim", "example", "goon", "vff", "stop", "teleop", "guard",
];

/// Runs a campaign.
fn faults(arguments: &[&str]) -> Output {
    let mut campaign = Command::new(env!("CARGO_BIN_EXE_jde-faults"));
    campaign.arg("--plugins").arg(plugins()).args(arguments);
    campaign.output().expect("it starts")
}

fn stdout(output: &Output) -> String {
    String::from_utf8(output.stdout.clone()).expect("the output is UTF-8")
}

/// The folder of the plugins, built if need be.
fn plugins() -> &'static Path {
    static FOLDER: OnceLock<PathBuf> = OnceLock::new();
    FOLDER.get_or_init(|| jde_test_plugins::folder(&PLUGINS))
}

#[test]
fn r1_r5_r7_r9_r11_hold_under_all_faults_in_lockstep() {
    let run = faults(&["--only", "lockstep", "--count", "40", "--seed", "5"]);
    let output = stdout(&run);
    assert_eq!(run.status.code(), Some(0), "{output}");
    let sum = output
        .lines()
        .find(|line| line.starts_with("| all |"))
        .expect("a sum");
    let figures: Vec<u64> = sum
        .split('|')
        .filter_map(|cell| cell.trim().parse().ok())
        .collect();
    let [demo, hundred, effective, survived] = figures[..] else {
        panic!("{sum}");
    };
    assert_eq!((demo + hundred, survived), (40, 40), "{sum}");
    assert!(effective > 15, "{sum}");
}

/// The commands of a hostile schema are random, ahead and back, near obstacles.
#[test]
fn r18_a_guarded_robot_touches_nothing_whatever_is_commanded() {
    let run = faults(&[
        "--only", "lockstep", "--kind", "reckless", "--count", "40", "--seed", "5",
    ]);
    assert_eq!(run.status.code(), Some(0), "{}", stdout(&run));
}

/// Delays on a machine that runs many tests are not faults, so this test does not judge periods.
#[test]
fn schemas_that_hang_and_crash_in_real_time_affect_no_other_schema() {
    let mut arguments = vec![
        "--only",
        "real-time",
        "--count",
        "8",
        "--seed",
        "5",
        "--no-rhythm",
    ];
    for kind in ["hang", "dawdle", "crash", "kill", "freeze", "reload", "panic"] {
        arguments.extend(["--kind", kind]);
    }
    let run = faults(&arguments);
    assert_eq!(run.status.code(), Some(0), "{}", stdout(&run));
}

#[test]
fn r16_a_case_of_one_seed_is_reproducible() {
    let injected = |seed| {
        let run = faults(&["--seed", seed, "--case", "lockstep/hundred/1"]);
        assert_eq!(run.status.code(), Some(0), "{}", stdout(&run));
        String::from_utf8(run.stderr).expect("the output is UTF-8")
    };
    assert_eq!(injected("3"), injected("3"));
    assert_ne!(injected("3"), injected("4"));
}

/// The arm has its first turn while the fault is in force.
#[test]
fn a_driver_that_has_not_started_is_given_no_fault() {
    let run = faults(&["--seed", "5", "--case", "lockstep/hundred/9"]);
    assert_eq!(run.status.code(), Some(0), "{}", stdout(&run));
}

/// Each kind of false data is found by its check and reported with the command that repeats the case.
#[test]
fn a_campaign_fails_when_an_invariant_is_violated() {
    for (tamper, expected, kind, count) in [
        ("withdrawal", "R7", "stop-all", "8"),
        ("stranger", "R7: `", "stop-all", "8"),
        ("brake", "` is in force, at ", "stop-all", "8"),
        ("motion", "motion: the robot moves", "stop-all", "8"),
        (
            "collision",
            "R18: the robot is guarded, and touches",
            "reckless",
            "40",
        ),
        ("turn", "R11: `", "stop-all", "8"),
        ("recovery", "and it has no turns any more", "panic", "16"),
        ("value", "values: `", "panic", "16"),
        ("lease", "R14: a lease ended", "leases", "8"),
        ("leak", "leak: ", "stop-all", "8"),
        (
            "held",
            "variables of an application that has ended",
            "stop-all",
            "2",
        ),
        ("memory", "MB of memory after", "stop-all", "80"),
    ] {
        // Two threads contest a schema in real time alone.
        let only = if tamper == "lease" {
            "real-time"
        } else {
            "lockstep"
        };
        let run = faults(&[
            "--only", only, "--kind", kind, "--count", count, "--seed", "5", "--tamper", tamper,
        ]);
        let output = stdout(&run);
        assert_eq!(run.status.code(), Some(1), "{tamper}: {output}");
        let violation = output.lines().find(|line| line.starts_with("broken: "));
        assert!(
            violation.is_some_and(|line| line.contains(expected)),
            "{tamper}: {output}"
        );
        // Memory is judged over many cases, so no single case repeats the failure.
        let command = format!("again: cargo xtask faults --seed 5 --kind {kind} --case {only}/");
        assert!(
            tamper == "memory" || output.contains(&command),
            "{tamper}: {output}"
        );
    }
}

#[test]
fn a_campaign_that_cannot_run_exits_with_status_2() {
    let run = faults(&["--only", "lockstep", "--kind", "line-cut"]);
    assert_eq!(run.status.code(), Some(2));
    let run = faults(&["--case", "somewhere/else/1"]);
    assert_eq!(run.status.code(), Some(2));
}
