//! Runs the tests of code that manages memory by hand under valgrind's memcheck. Does not look for data races, which loom
//! finds: valgrind takes the ordered accesses of the cells for unprotected ones.

use std::process::Command;

use anyhow::Result;

use crate::prerequisites::INSTALL_VALGRIND;
use crate::programs;
use crate::shell;
use crate::step::StepOutcome;
use crate::test::Context;

/// The tests: folder of the package and name.
pub(crate) const TESTS: &[(&str, &str)] = &[
    ("plugin/abi", "read"),
    ("runtime/board", "torture"),
    ("plugin/schema", "conformance"),
];

/// A definite leak is an error. Without fair scheduling, a spinning thread may starve the others.
const OPTIONS: &[&str] = &[
    "--quiet",
    "--error-exitcode=1",
    "--fair-sched=try",
    "--leak-check=full",
    "--show-leak-kinds=definite",
    "--errors-for-leak-kinds=definite",
];

/// The percentage of the cells' torture rounds to run, since memcheck is about 30 times slower.
const ROUNDS: (&str, &str) = ("JDE_TORTURE", "1");

pub(crate) fn run(context: &Context) -> Result<StepOutcome> {
    if !is_installed() {
        return context.missing_tool("valgrind", INSTALL_VALGRIND);
    }
    // For the whole workspace: for single packages cargo would choose other features of the libraries and
    // build them again.
    let mut selection = Context::workspace();
    selection.extend(TESTS.iter().flat_map(|(_, name)| ["--test", name]));
    let built = programs::build(context, &selection)?;
    for (folder, name) in TESTS {
        let program = programs::find(&built, folder, name)?;
        let mut valgrind = Command::new("valgrind");
        valgrind.args(OPTIONS).arg(suppressions(context)).envs([ROUNDS]);
        program.run_by(&mut valgrind);
        shell::run(&mut valgrind, context.paint)?;
    }
    Ok(StepOutcome::Passed)
}

/// Names the file of the errors that are none, each with its reason.
fn suppressions(context: &Context) -> String {
    let file = context.root.join("xtask/valgrind.supp");
    format!("--suppressions={}", file.display())
}

/// Whether valgrind can start programs.
pub(crate) fn is_installed() -> bool {
    shell::succeeds(Command::new("valgrind").args(["--quiet", "true"]))
}
