//! Runs the stories in `scenarios/` at the root of the repository, and checks that each rule has one.
//!
//! It refuses stories that it does not understand: an unknown key, phrase or name fails with the file and the
//! step.

use std::collections::BTreeMap;
use std::fs;
use std::path::PathBuf;

use crate::story::Story;

/// Rules that the state machine alone cannot show, and where they are tested.
const ELSEWHERE: [(&str, &str); 2] = [
    (
        "R8",
        "values of modulations are never torn and keep still within an iteration: held by the variables' cells",
    ),
    (
        "R11",
        "absolute deadlines and skipped periods belong to the executors' clocks",
    ),
];

#[test]
fn every_story_goes_as_told() {
    let failures: Vec<String> = stories()
        .into_iter()
        .filter_map(|(file, text)| {
            let story = match Story::parse(&text) {
                Ok(story) => story,
                Err(error) => return Some(format!("{file}: {error}")),
            };
            story
                .play()
                .err()
                .map(|error| format!("{file}, \"{}\", {error}", story.title()))
        })
        .collect();
    assert!(failures.is_empty(), "\n{}", failures.join("\n"));
}

#[test]
fn every_rule_has_a_story_or_a_holder_elsewhere() {
    let mut told: BTreeMap<String, Vec<String>> = BTreeMap::new();
    for (file, text) in stories() {
        let story = Story::parse(&text).unwrap_or_else(|error| panic!("{file}: {error}"));
        for rule in story.rules() {
            told.entry(rule.clone()).or_default().push(file.clone());
        }
    }
    let rules: Vec<String> = (1..=17).map(|n| format!("R{n}")).collect();
    for rule in &rules {
        let elsewhere = ELSEWHERE.iter().any(|(held, _)| held == rule);
        assert!(
            told.contains_key(rule) != elsewhere,
            "{rule} must have a story or a holder elsewhere, not both"
        );
    }
    for (rule, files) in &told {
        assert!(rules.contains(rule), "{rule} in {files:?} is no rule");
    }
}

#[test]
fn a_story_that_goes_otherwise_is_caught() {
    let story = |expected: &str| {
        let text = format!(
            "title = 'one root'\nrule = ['R3']\n[groups.roots]\nmembers = ['a']\n[[step]]\nat = '1ms'\n\
             when = ['the application starts', 'a becomes ready']\n{expected}\n"
        );
        Story::parse(&text).and_then(|story| story.play())
    };
    assert_eq!(story("winner = { roots = 'a' }"), Ok(()));
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
        let told = story(wrong).expect_err(wrong);
        assert!(told.contains("step 1 at 1ms"), "{told} does not name the step");
    }
    for nonsense in [
        "winner = { nowhere = 'a' }",
        "when = ['a flies']",
        "states = { b = 'ready' }",
        "wenn = []",
    ] {
        assert!(story(nonsense).is_err(), "{nonsense} was understood");
    }
}

fn stories() -> Vec<(String, String)> {
    let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../scenarios");
    let entries = fs::read_dir(&folder).unwrap_or_else(|error| panic!("{}: {error}", folder.display()));
    let mut stories: Vec<_> = entries
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
    stories.sort();
    assert!(!stories.is_empty(), "no stories in {}", folder.display());
    stories
}
