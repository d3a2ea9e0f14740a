//! Tests that handle memory by themselves, run under valgrind's memcheck. Races are for loom to find: valgrind
//! takes the ordered loads and stores of the cells for unprotected ones.

use std::process::Command;

use anyhow::Result;

use crate::cargo_json;
use crate::prerequisites::INSTALL_VALGRIND;
use crate::shell;
use crate::step::Done;
use crate::test::Context;

/// A test, how strictly to look at it, and what makes it short enough: memcheck takes some 30 times as long.
struct Subject {
    test: &'static str,
    options: &'static [&'static str],
    variables: &'static [(&'static str, &'static str)],
}

const SUBJECTS: &[Subject] = &[Subject {
    test: "torture",
    options: &[
        "--leak-check=full",
        "--show-leak-kinds=definite",
        "--errors-for-leak-kinds=definite",
    ],
    variables: &[("JDE_TORTURE", "1")],
}];

pub(crate) fn run(context: &Context) -> Result<Done> {
    if !shell::succeeds(Command::new("valgrind").args(["--quiet", "true"])) {
        return context.lacks("valgrind", INSTALL_VALGRIND);
    }
    for subject in SUBJECTS {
        let program = cargo_json::build_test(context, subject.test)?;
        let mut valgrind = Command::new("valgrind");
        // Without fair scheduling a spinning thread may keep the others from running at all.
        valgrind
            .args(["--quiet", "--error-exitcode=1", "--fair-sched=try"])
            .args(subject.options);
        valgrind.envs(subject.variables.iter().copied());
        program.run_by(&mut valgrind);
        shell::run(&mut valgrind, context.paint)?;
    }
    Ok(Done::Passed)
}
