//! One suite for all executors and languages: threads, pool and lockstep keep the same rules, and so do schemas in Rust, C, C++
//! and Python. The name of each test states its rule.

use std::collections::{BTreeMap, BTreeSet};

#[path = "../common/mod.rs"]
mod common;

mod arbitration;
mod boundary;
mod chattering;
mod contracts;
mod exceptions;
mod failing_exports;
mod faults;
mod gestures;
mod guards;
mod hangs;
mod hangs_at_the_end;
mod hangs_in_c;
mod judgements;
mod listed_commands;
mod many_schemas;
mod mocks;
mod operators;
mod panels;
mod panels_in_time;
mod records;
mod reload;
mod remote;
mod selection;
mod shutdown;
mod stopping;
mod takeover;
mod time;
mod unload;
mod unwitnessed;
mod validity;
mod values;

/// The page states how many tests of each suite run in each language.
#[test]
fn the_table_of_languages_is_that_of_the_page() {
    let program = std::env::current_exe().expect("this program has a file");
    let listed = std::process::Command::new(program)
        .arg("--list")
        .output()
        .expect("it lists its tests");
    let listed = String::from_utf8(listed.stdout).expect("UTF-8");
    let mut suites = BTreeMap::<&str, [BTreeSet<&str>; 4]>::new();
    for name in listed.lines().filter_map(|line| line.strip_suffix(": test")) {
        let path: Vec<_> = name.split("::").collect();
        let [suite, .., before, last] = path[..] else {
            continue;
        };
        let language = ["rust", "c", "cpp", "python"]
            .iter()
            .position(|name| *name == last);
        let function = if language.is_some() { before } else { last };
        let functions = suites.entry(suite).or_default();
        functions[language.unwrap_or(0)].insert(function);
    }
    suites.retain(|_, languages| languages[1..].iter().any(|functions| !functions.is_empty()));
    let rows = suites.into_iter().map(|(suite, languages)| {
        let [rust, c, cpp, python] = languages.map(|functions| functions.len());
        format!("| `{suite}` | {rust} | {c} | {cpp} | {python} |\n")
    });
    let page = include_str!("../../../../docs/testing.md");
    let table: String = page
        .lines()
        .filter(|line| line.starts_with("| `"))
        .map(|line| format!("{line}\n"))
        .collect();
    assert_eq!(table, rows.collect::<String>(), "docs/testing.md");
}
