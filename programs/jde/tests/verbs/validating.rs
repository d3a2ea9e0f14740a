//! `jde validate`, which runs each check of a plugin in a process of its own.

use std::fs;

use crate::support::{PLUGINS, jde, jde_with_plugins, json, output_of};

#[test]
fn shipped_plugins_keep_their_promises() {
    for plugin in PLUGINS {
        let validated = output_of(&mut jde_with_plugins(&["validate", plugin]));
        assert_eq!(
            validated.status,
            Some(0),
            "{plugin}: {}{}",
            validated.out,
            validated.err
        );
        assert!(
            validated.out.contains("ok      survives"),
            "{plugin}: {}",
            validated.out
        );
        assert!(!validated.out.contains('\u{1b}'), "no colours in a pipe");
    }
}

#[test]
fn a_file_that_is_no_plugin_fails_the_first_check() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("libnothing.so");
    fs::write(&file, "nothing").expect("a file");
    let validated = output_of(&mut jde(&["validate", "--json", &file.display().to_string()]));
    assert_eq!(validated.status, Some(1), "{}", validated.err);
    let findings = json(&validated.out);
    assert_eq!(findings[0]["check"], "loads");
    assert_eq!(findings[0]["result"], "failed");
    assert_eq!(findings.as_array().map(Vec::len), Some(1));
}

#[test]
fn the_checks_are_listed_and_a_mistyped_one_is_refused() {
    let list = output_of(&mut jde(&["validate", "--list"]));
    assert!(
        list.out.lines().any(|line| line.starts_with("silent ")),
        "{}",
        list.out
    );
    let mistyped = output_of(&mut jde_with_plugins(&["validate", "stop", "--only", "silence"]));
    assert_eq!(mistyped.status, Some(2));
    assert!(
        mistyped.err.contains("did you mean `silent`?"),
        "{}",
        mistyped.err
    );
}
