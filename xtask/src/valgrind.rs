//! Tests that handle memory by themselves, run under valgrind's memcheck, and the instructions of the hot paths (see `counts`).
//! Races are for loom to find: valgrind takes the ordered loads and stores of the cells for unprotected ones.

use std::process::Command;

use anyhow::Result;

use crate::cargo_json;
use crate::counts;
use crate::prerequisites::INSTALL_VALGRIND;
use crate::shell;
use crate::step::Done;
use crate::test::Context;

/// The tests, by folder and name.
const TESTS: &[(&str, &str)] = &[
    ("crates/abi", "read"),
    ("crates/board", "torture"),
    ("crates/schema", "conformance"),
];

/// What leaks for certain is an error. Without fair scheduling a spinning thread may keep the others from running.
const OPTIONS: &[&str] = &[
    "--quiet",
    "--error-exitcode=1",
    "--fair-sched=try",
    "--leak-check=full",
    "--show-leak-kinds=definite",
    "--errors-for-leak-kinds=definite",
];

/// Percent of the rounds of the cells' torture: memcheck takes some 30 times as long.
const ROUNDS: (&str, &str) = ("JDE_TORTURE", "1");

pub(crate) fn run(context: &Context) -> Result<Done> {
    if !shell::succeeds(Command::new("valgrind").args(["--quiet", "true"])) {
        return context.lacks("valgrind", INSTALL_VALGRIND);
    }
    for program in cargo_json::build_tests(context, TESTS)? {
        let mut valgrind = Command::new("valgrind");
        valgrind.args(OPTIONS).envs([ROUNDS]);
        program.run_by(&mut valgrind);
        shell::run(&mut valgrind, context.paint)?;
    }
    counts::check(&context.root, context.paint)?;
    Ok(Done::Passed)
}
