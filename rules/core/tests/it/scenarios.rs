//! Plays the files in `scenarios/` at the root of the repository, and checks that each rule has one.
//!
//! An unknown key, phrase or name fails with the file and the step.

use std::collections::BTreeMap;
use std::fs;
use std::path::PathBuf;

use crate::scenario::Scenario;

/// Rules that the state machine alone cannot show, and the part that keeps them.
const OTHER_TESTS: [(&str, &str); 2] = [
    (
        "R8",
        "values of modulations are never torn and do not change within an iteration; the cells of variables keep this",
    ),
    (
        "R11",
        "absolute deadlines and skipped periods belong to the executors' clocks",
    ),
];

#[test]
fn every_scenario_has_the_expected_effects() {
    let failures: Vec<String> = scenarios()
        .into_iter()
        .filter_map(|(file, text)| {
            let scenario = match Scenario::parse(&text) {
                Ok(scenario) => scenario,
                Err(error) => return Some(format!("{file}: {error}")),
            };
            scenario
                .play()
                .err()
                .map(|error| format!("{file}, \"{}\", {error}", scenario.title()))
        })
        .collect();
    assert!(failures.is_empty(), "\n{}", failures.join("\n"));
}

#[test]
fn every_rule_has_a_scenario_or_is_kept_elsewhere() {
    let mut files_of_rule: BTreeMap<String, Vec<String>> = BTreeMap::new();
    for (file, text) in scenarios() {
        let scenario = Scenario::parse(&text).unwrap_or_else(|error| panic!("{file}: {error}"));
        for rule in scenario.rules() {
            files_of_rule.entry(rule.clone()).or_default().push(file.clone());
        }
    }
    let rules: Vec<String> = (1..=18).map(|n| format!("R{n}")).collect();
    for rule in &rules {
        let elsewhere = OTHER_TESTS.iter().any(|(other, _)| other == rule);
        assert!(
            files_of_rule.contains_key(rule) != elsewhere,
            "{rule} must have either a scenario or an entry in OTHER_TESTS"
        );
    }
    for (rule, files) in &files_of_rule {
        assert!(rules.contains(rule), "{rule} in {files:?} is not a rule");
    }
}

#[test]
fn a_scenario_with_other_effects_fails() {
    let scenario = |expected: &str| {
        let text = format!(
            "title = 'one root'\nrule = ['R3']\n[groups.roots]\nmembers = ['a']\n[[step]]\nat = '1ms'\n\
             when = ['the application starts', 'a becomes ready']\n{expected}\n"
        );
        Scenario::parse(&text).and_then(|scenario| scenario.play())
    };
    assert_eq!(scenario("winner = { roots = 'a' }"), Ok(()));
    for wrong in [
        "winner = { roots = 'nobody' }",
        "states = { a = 'ready' }",
        "order = ['a is promoted', 'a wakes']",
        "order = ['roots brakes']",
        "never = ['a is promoted']",
        "authority = []",
        "why = { roots = { case = 'collision' } }",
        "refused = ['anything']",
        "contract = { roots = 'nothing' }",
        "timer = '5ms'",
        "health = { a = 'overrun' }",
    ] {
        let error = scenario(wrong).expect_err(wrong);
        assert!(error.contains("step 1 at 1ms"), "{error} does not name the step");
    }
    for invalid in [
        "winner = { nowhere = 'a' }",
        "when = ['a flies']",
        "states = { b = 'ready' }",
        "wenn = []",
    ] {
        assert!(scenario(invalid).is_err(), "{invalid} was accepted");
    }
}

fn scenarios() -> Vec<(String, String)> {
    let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../scenarios");
    let entries = fs::read_dir(&folder).unwrap_or_else(|error| panic!("{}: {error}", folder.display()));
    let mut scenarios: Vec<_> = entries
        .map(|entry| entry.expect("a readable folder").path())
        .filter(|path| path.extension().is_some_and(|e| e == "toml"))
        .map(|path| {
            let text =
                fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
            (
                path.file_name().expect("a file").to_string_lossy().into_owned(),
                text,
            )
        })
        .collect();
    scenarios.sort();
    assert!(!scenarios.is_empty(), "no scenarios in {}", folder.display());
    scenarios
}
