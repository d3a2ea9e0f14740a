//! The steps of `cargo xtask test` in their order. Each step runs one or two commands; a longer step has its
//! own file. The steps share one build as far as their flags allow.

use anyhow::Result;

use crate::programs::{self, Job};
use crate::step::{StepOutcome, TestStep};
use crate::test::{Context, LINTING_COMPILER};
use crate::{
    browser, clusters, counts, demo, extending, foxglove, headers, lints, manual, mujoco, package,
    parameters, peers, prerequisites, pytest, ros2, shell, tidy, tutorial, valgrind,
};

/// The benches and the fuzzers are separate workspaces.
pub(crate) const WORKSPACES: &[&str] = &[PRODUCT, BENCHES, FUZZERS];
const PRODUCT: &str = "Cargo.toml";
pub(crate) const BENCHES: &str = "benches/Cargo.toml";
const FUZZERS: &str = "fuzz/Cargo.toml";

pub(crate) const STEPS: &[TestStep<Context>] = &[
    TestStep {
        name: "prerequisites",
        title: "compilers of C and C++, CMake, valgrind, Python, Slurm, rustfmt and clippy",
        help: "install what is named above; `cargo xtask test --install` does it",
        is_heavy: false,
        needs: &[],
        run: prerequisites::run,
    },
    TestStep {
        name: "fmt",
        title: "the layout of the code",
        help: "run `cargo fmt --all` in the workspace whose command is the last above",
        is_heavy: false,
        needs: &[],
        run: fmt,
    },
    TestStep {
        name: "tidy",
        title: "what the compiler cannot check",
        help: "see each place above",
        is_heavy: false,
        needs: &[],
        run: tidy,
    },
    TestStep {
        name: "advisories",
        title: "no library with a known vulnerability",
        help: "see above: update the library, or state in deny.toml why it is harmless",
        is_heavy: true,
        needs: &[],
        run: advisories,
    },
    TestStep {
        name: "headers",
        title: "the C headers match the Rust source",
        help: "run `cargo xtask headers` and review the changes",
        is_heavy: false,
        needs: &[],
        run: headers,
    },
    TestStep {
        name: "build",
        title: "the executable, its plugins and all tests",
        help: "see the compiler's errors above; `cargo build --workspace --all-targets` shows them again",
        is_heavy: false,
        needs: &[],
        run: build,
    },
    TestStep {
        name: "lints",
        title: "clippy, warnings are errors",
        help: "see above; `cargo clippy --workspace --all-targets` shows them again",
        is_heavy: false,
        needs: &["build"],
        run: lints::run,
    },
    TestStep {
        name: "benches",
        title: "clippy of the benches",
        help: "see above; `cargo clippy --manifest-path benches/Cargo.toml --workspace --all-targets` shows them again",
        is_heavy: true,
        needs: &["build"],
        run: lints::run_benches,
    },
    TestStep {
        name: "first",
        title: "what the first command of a checkout builds, with the few features of its libraries",
        help: "see above; a package uses a feature of a library that only others select: `cargo check` shows it again",
        is_heavy: true,
        needs: &["build"],
        run: first,
    },
    TestStep {
        name: "docs",
        title: "the documentation, warnings are errors",
        help: "see above; `cargo doc --workspace --no-deps` shows them again",
        is_heavy: true,
        needs: &["build"],
        run: docs,
    },
    TestStep {
        name: "loom",
        title: "the cells of variables and the gate of calls, in every interleaving of their threads",
        help: "see above; the trace shows the interleaving that fails",
        is_heavy: true,
        needs: &["build"],
        run: loom,
    },
    TestStep {
        name: "counts",
        title: "the instructions of the hot paths",
        help: "see the path above that takes more instructions; `cargo xtask counts` counts them again",
        is_heavy: true,
        needs: &["build"],
        run: counts::step,
    },
    TestStep {
        name: "tests",
        title: "all tests, including those in the documentation",
        help: "see above; `cargo test -p <crate> <name>` runs one again",
        is_heavy: false,
        needs: &["build"],
        run: tests,
    },
    TestStep {
        name: "packages",
        title: "packages, installed and removed in a fresh Debian without Rust",
        help: "see the output of the command above; the packages are in target/package, the Debian in target/package/root",
        is_heavy: true,
        needs: &["build"],
        run: package::trial::run,
    },
    TestStep {
        name: "valgrind",
        title: "memory errors in tables, plugins and cells",
        help: "see above: the stack of an error, each line of which is in a test",
        is_heavy: true,
        needs: &["build"],
        run: valgrind::run,
    },
    TestStep {
        name: "demo",
        title: "the demonstration gives identical decisions twice, the second time as on another processor",
        help: "two runs of one seed must make the same decisions (R16); search for a clock, a hash map, a thread or a function of the C library",
        is_heavy: true,
        needs: &["build"],
        run: demo::run,
    },
    TestStep {
        name: "parameters",
        title: "the page of parameters matches the plugins",
        help: "run `cargo xtask parameters` and review the changes",
        is_heavy: true,
        needs: &["build"],
        run: parameters::step,
    },
    TestStep {
        name: "peers",
        title: "independent programs drive the simulated robot and read recordings",
        help: "see the output of the client and the server above",
        is_heavy: true,
        needs: &["build"],
        run: peers::run,
    },
    TestStep {
        name: "ros2",
        title: "ROS 2 itself and jde drive each other's robots",
        help: "see the output of the programs of ROS 2 above",
        is_heavy: true,
        needs: &["build"],
        run: ros2::step,
    },
    TestStep {
        name: "python",
        title: "the Python package: its style, its types and its tests",
        help: "see above; `PYTHONPATH=target/python target/pytest/bin/python -m pytest programs/python` runs the tests again",
        is_heavy: true,
        needs: &["build"],
        run: pytest::run,
    },
    TestStep {
        name: "browser",
        title: "the page from the robot, in Chromium",
        help: "see above; what the browser showed is in target/browser",
        is_heavy: true,
        needs: &["build"],
        run: browser::run,
    },
    TestStep {
        name: "foxglove",
        title: "Foxglove's own client, two thousand values a second, and a reader that does not read",
        help: "see above: the script is programs/web/tests/foxglove.mjs",
        is_heavy: true,
        needs: &["build"],
        run: foxglove::run,
    },
    TestStep {
        name: "mujoco",
        title: "robots that MuJoCo moves: bases with wheels, and an arm",
        help: "see above; the interpreter with MuJoCo is target/mujoco/bin/python",
        is_heavy: true,
        needs: &["build"],
        run: mujoco::run,
    },
    TestStep {
        name: "dask",
        title: "an experiment on a Dask cluster that loses a worker",
        help: "see target/clusters/dask/*.log: the scheduler, each worker, and the example that submits the parts",
        is_heavy: true,
        needs: &["build"],
        run: clusters::dask::run,
    },
    TestStep {
        name: "slurm",
        title: "an experiment as a Slurm job array, a task of which is killed",
        help: "see target/clusters/slurm/*.log: the daemons, each part, and the job that joins the parts",
        is_heavy: true,
        needs: &["build"],
        run: clusters::slurm::run,
    },
    TestStep {
        name: "tutorial",
        title: "the steps of docs/tutorial, with the output that they show",
        help: "see above what was printed: change the page, or what it describes; the files are in target/tutorial",
        is_heavy: true,
        needs: &["build"],
        run: tutorial::run,
    },
    TestStep {
        name: "manual",
        title: "the manual, and every link of it",
        help: "see the links above; `cargo xtask manual` builds it again",
        is_heavy: true,
        needs: &["build"],
        run: manual::step,
    },
    TestStep {
        name: "extending",
        title: "the changes that docs/extending.md shows, in a copy of the project",
        help: "change the page with the code; `git diff` of a trial writes a new change",
        is_heavy: true,
        needs: &["build"],
        run: extending::run,
    },
];

fn fmt(context: &Context) -> Result<StepOutcome> {
    if !shell::succeeds(&mut context.cargo(&["fmt", "--version"])) {
        return context.missing_tool("rustfmt", "rustup component add rustfmt");
    }
    for workspace in WORKSPACES {
        // File names only: the remedy is always to run rustfmt.
        let mut cargo = context.cargo(&["fmt", "--all", "--manifest-path", workspace, "--"]);
        shell::run(cargo.args(["--check", "--files-with-diff"]), context.paint)?;
    }
    Ok(StepOutcome::Passed)
}

fn tidy(context: &Context) -> Result<StepOutcome> {
    tidy::run(&context.root)?;
    Ok(StepOutcome::Passed)
}

/// Skipped without `cargo-deny`, in CI too: building it takes minutes, and its database is a repository that
/// may be unreachable.
fn advisories(context: &Context) -> Result<StepOutcome> {
    if !shell::succeeds(&mut context.cargo(&["deny", "--version"])) {
        let why = "cargo-deny is not installed: cargo install cargo-deny --locked";
        return Ok(StepOutcome::Skipped(why.to_owned()));
    }
    for workspace in WORKSPACES {
        let mut deny = context.cargo(&["deny", "--manifest-path", workspace, "check"]);
        // An exception that one workspace needs may be unused in another.
        deny.args(["--allow", "advisory-not-detected"]);
        shell::run(deny.arg("advisories"), context.paint)?;
    }
    Ok(StepOutcome::Passed)
}

fn headers(context: &Context) -> Result<StepOutcome> {
    headers::check(&context.root)?;
    Ok(StepOutcome::Passed)
}

/// Builds everything once: for the lints, the tests and the demonstration.
fn build(context: &Context) -> Result<StepOutcome> {
    context.run(lints::build_all(context))
}

fn tests(context: &Context) -> Result<StepOutcome> {
    let selection = context.selection();
    let programs = programs::build(context, &selection)?;
    let plugins = match context.options.package {
        // The tests of the package build the plugins that they load.
        Some(_) => None,
        None => Some(programs::copy_plugins(&context.target)?),
    };
    let mut jobs: Vec<Job> = programs
        .iter()
        .map(|program| program.job(&context.root))
        .collect();
    let mut command = context.cargo(&["test", "--doc", "--no-fail-fast"]);
    command.args(&selection);
    jobs.push(Job::last("documentation", command));
    if context.options.package.is_none() {
        // The tests of two packages of the benches. The programs that the benches compare with take minutes to
        // build; only the lints build them.
        let packages = ["--package", "jde-measure", "--package", "jde-bench-ros2"];
        let mut command = context.cargo(&["test", "--manifest-path", BENCHES]);
        command.args(packages).arg("--target-dir").arg(&context.target);
        jobs.push(Job::last("benches", command));
    }
    for job in &mut jobs {
        // Some tests build plugins, which the first step has built for this compiler.
        job.command.envs(context.compiler());
        job.command.envs(
            plugins
                .as_ref()
                .map(|folder| (jde_test_plugins::VARIABLE, folder)),
        );
    }
    // Without this variable the tests of windows pass when no window can be opened. With it they fail.
    if context.ci || prerequisites::has_screen() {
        for job in &mut jobs {
            job.command.env("JDE_TEST_SCREEN", "1");
        }
    }
    programs::run_all(jobs, context.paint)?;
    for program in programs.iter().filter(|program| !program.runs_again()) {
        context.empty(program.path())?;
    }
    context.clear(&context.target.join("tmp"))?;
    Ok(StepOutcome::Passed)
}

/// Uses separate flags, and therefore its own target folder. In a shared folder the two builds would rebuild
/// each other's crates.
fn loom(context: &Context) -> Result<StepOutcome> {
    let packages = ["--package", "jde-board", "--package", "jde-gate"];
    let mut cargo = context.cargo(&["test", "--release", "--test", "loom"]);
    cargo.args(packages);
    cargo.env("RUSTFLAGS", with_flag("RUSTFLAGS", "--cfg loom"));
    cargo.env("CARGO_TARGET_DIR", context.target.join("loom"));
    context.run(cargo)
}

/// Checks the default members alone. The step before builds them with the features that all others select.
fn first(context: &Context) -> Result<StepOutcome> {
    let mut cargo = context.cargo(&["check"]);
    cargo.env_remove(LINTING_COMPILER);
    context.run(cargo)
}

fn docs(context: &Context) -> Result<StepOutcome> {
    let mut cargo = context.cargo(&["doc", "--workspace", "--no-deps"]);
    // The lints of the build are not repeated.
    cargo.env_remove(LINTING_COMPILER);
    cargo.env("RUSTDOCFLAGS", with_flag("RUSTDOCFLAGS", "-D warnings"));
    context.run(cargo)
}

/// Returns the caller's flags with one more flag.
fn with_flag(variable: &str, flag: &str) -> String {
    std::env::var(variable).map_or_else(|_| flag.to_owned(), |flags| format!("{flags} {flag}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_step_needs_only_steps_before_it() {
        for (index, step) in STEPS.iter().enumerate() {
            for need in step.needs {
                let before = STEPS[..index].iter().any(|earlier| earlier.name == *need);
                assert!(before, "{} needs {need}", step.name);
            }
        }
    }
}
