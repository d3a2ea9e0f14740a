//! Tests that handle memory by themselves, run under valgrind's memcheck. Races are for loom to find: valgrind
//! takes the ordered loads and stores of the cells for unprotected ones.

use std::process::Command;

use anyhow::Result;

use crate::prerequisites::INSTALL_VALGRIND;
use crate::shell;
use crate::step::Done;
use crate::test::Context;

/// A test program and how strictly to look.
struct Subject {
    test: &'static str,
    options: &'static [&'static str],
}

const SUBJECTS: [Subject; 1] = [Subject {
    test: "torture",
    options: &["--leak-check=full", "--errors-for-leak-kinds=definite"],
}];

pub(crate) fn run(context: &Context) -> Result<Done> {
    if !shell::succeeds(Command::new("valgrind").args(["--quiet", "true"])) {
        return context.lacks("valgrind", INSTALL_VALGRIND);
    }
    for subject in SUBJECTS {
        let program = crate::cargo_json::build_test(context, subject.test)?;
        let mut valgrind = Command::new("valgrind");
        // Without fair scheduling a spinning thread may keep the others from running at all.
        valgrind
            .args(["--quiet", "--error-exitcode=1", "--fair-sched=try"])
            .args(subject.options);
        valgrind.arg(program).current_dir(&context.root);
        shell::run(&mut valgrind, context.paint)?;
    }
    Ok(Done::Passed)
}
