//! The offences, each planted in a build of `planted.c`, and the checks that name them.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Duration;

use jde_isolation::Program;
use jde_validate::{CHECKS, CheckResult, Finding, validate};
use jde_watchdog::Watchdog;

/// The checks, each with the offence that it is meant for. Their place is the number that `planted.c` gives the offence.
const OFFENCES: &[&str] = &[
    "loads",
    "documented",
    "survives",
    "stays",
    "returns",
    "creates",
    "statuses",
    "reasons",
    "panics",
    "ports",
    "loans",
    "values",
    "times",
    "calls",
    "checks",
    "preconditions",
    "no-values",
    "unbound",
    "refused",
    "old-host",
    "again",
    "instances",
    "repeats",
    "threads",
    "files",
    "memory",
    "process",
    "silent",
    "panel",
    "drawing",
    "state",
    "arbitrates",
    "inspects",
];

/// A test runs a check of three kinds of trouble with this timeout; all other calls take microseconds.
const TIMEOUT: Duration = Duration::from_secs(20);

/// Builds the plugin with an offence; 0 is none.
fn build(folder: &Path, offence: usize) -> PathBuf {
    let root = env!("CARGO_MANIFEST_DIR");
    let file = folder.join(format!("libplanted{offence}.so"));
    let output = Command::new("cc")
        .args(["-shared", "-fPIC", "-std=gnu11", "-pthread", "-Wall", "-I"])
        .arg(format!("{root}/../../include"))
        .arg(format!("-DOFFENCE={offence}"))
        .arg("-o")
        .arg(&file)
        .arg(format!("{root}/tests/it/planted.c"))
        .output()
        .expect("a C compiler named cc is installed");
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
    file
}

fn program() -> Program {
    Program {
        path: std::env::current_exe().expect("this program has a file"),
        arguments: ["--exact", "--nocapture", "--quiet", "served"]
            .map(Into::into)
            .to_vec(),
    }
}

fn failed(findings: &[Finding]) -> Vec<(&str, &str)> {
    let failed = findings.iter().filter_map(|finding| match &finding.verdict {
        CheckResult::Failed(words) => Some((finding.check, words.as_str())),
        CheckResult::Ok | CheckResult::Skipped(_) => None,
    });
    failed.collect()
}

fn check(offence: usize, timeout: Duration) {
    let folder = tempfile::tempdir().expect("a folder");
    let file = build(folder.path(), offence);
    let findings = validate(&file, &program(), &[], timeout).expect("processes start");
    let failed = failed(&findings);
    let expected: Vec<&str> = offence
        .checked_sub(1)
        .map(|place| OFFENCES[place])
        .into_iter()
        .collect();
    let names: Vec<&str> = failed.iter().map(|(check, _)| *check).collect();
    assert_eq!(names, expected, "offence {offence}: {failed:?}");
}

#[test]
fn a_plugin_that_keeps_its_promises_fails_no_check() {
    let _watchdog = Watchdog::for_test();
    check(0, TIMEOUT);
}

#[test]
fn each_offence_is_named_by_exactly_the_check_meant_for_it() {
    let _watchdog = Watchdog::for_test();
    for (place, name) in OFFENCES.iter().enumerate() {
        // Only the call that does not return lasts as long as it may.
        let timeout = if *name == "returns" {
            Duration::from_secs(2)
        } else {
            TIMEOUT
        };
        check(place + 1, timeout);
    }
    for check in CHECKS {
        let has_offence = OFFENCES.contains(&check.name);
        assert!(
            has_offence || check.name == "judges",
            "no offence for `{}`",
            check.name
        );
    }
}

#[test]
fn a_process_that_does_not_end_is_ended() {
    let _watchdog = Watchdog::for_test();
    let folder = tempfile::tempdir().expect("a folder");
    let file = build(folder.path(), OFFENCES.len() + 1);
    let findings = validate(&file, &program(), &[], Duration::from_secs(2)).expect("processes start");
    let [(check, words)] = failed(&findings)[..] else {
        panic!("{findings:?}");
    };
    assert_eq!(check, "loads");
    assert!(words.contains("the end of its process"), "{words}");
}

#[test]
fn only_the_chosen_checks_are_shown() {
    let _watchdog = Watchdog::for_test();
    let folder = tempfile::tempdir().expect("a folder");
    let file = build(folder.path(), 0);
    let chosen = [String::from("silent")];
    let findings = validate(&file, &program(), &chosen, TIMEOUT).expect("processes start");
    let shown: Vec<_> = findings
        .iter()
        .map(|finding| (finding.check, finding.verdict.clone()))
        .collect();
    assert_eq!(shown, [("silent", CheckResult::Ok)]);
    assert!(validate(&file, &program(), &[String::from("loud")], TIMEOUT).is_err());
}
