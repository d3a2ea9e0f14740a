//! The steps of `cargo xtask test` in their order. Each step runs one or two commands; a longer step has its
//! own file. The steps share one build as far as their flags allow.

use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};
use std::{fs, io};

use anyhow::{Context as _, Result, bail};
use clap::builder::PossibleValuesParser;

use crate::metadata::Metadata;
use crate::paint::Paint;
use crate::programs::{self, Job};
use crate::step::{self, Step, StepOutcome, StepSelection};
use crate::{
    clusters, demo, extending, headers, lints, manual, package, parameters, peers, prerequisites, pytest,
    ros2, shell, tidy, tutorial, valgrind,
};

/// The context of every step.
pub(crate) struct Context {
    pub(crate) root: PathBuf,
    /// Cargo's target folder.
    pub(crate) target: PathBuf,
    /// Whether this runs in CI, where a missing program is a failure.
    pub(crate) ci: bool,
    pub(crate) options: Options,
    pub(crate) paint: Paint,
    /// The compiler that also lints; `None` if it is not installed.
    linting_compiler: Option<PathBuf>,
}

/// The options for all steps.
#[derive(Debug, Default)]
pub(crate) struct Options {
    /// Whether missing programs may be installed.
    pub(crate) install: bool,
    /// Whether the benches and the fuzzers are linted too.
    pub(crate) all: bool,
    /// The only package to lint and to test.
    pub(crate) package: Option<String>,
}

/// The benches and the fuzzers are separate workspaces.
pub(crate) const WORKSPACES: &[&str] = &[PRODUCT, BENCHES, FUZZERS];
const PRODUCT: &str = "Cargo.toml";
pub(crate) const BENCHES: &str = "benches/Cargo.toml";
pub(crate) const FUZZERS: &str = "fuzz/Cargo.toml";

const STEPS: &[Step<Context>] = &[
    Step {
        name: "prerequisites",
        title: "compilers of C and C++, CMake, valgrind, Python, Slurm, rustfmt and clippy",
        help: "install what is named above; `cargo xtask test --install` does it",
        is_heavy: false,
        needs: &[],
        run: prerequisites::run,
    },
    Step {
        name: "fmt",
        title: "the layout of the code",
        help: "run `cargo fmt --all` in the workspace whose command is the last above",
        is_heavy: false,
        needs: &[],
        run: fmt,
    },
    Step {
        name: "tidy",
        title: "what the compiler cannot check",
        help: "see each place above",
        is_heavy: false,
        needs: &[],
        run: tidy,
    },
    Step {
        name: "advisories",
        title: "no library with a known vulnerability",
        help: "see above: update the library, or state in deny.toml why it is harmless",
        is_heavy: true,
        needs: &[],
        run: advisories,
    },
    Step {
        name: "headers",
        title: "the C headers match the Rust source",
        help: "run `cargo xtask headers` and review the changes",
        is_heavy: false,
        needs: &[],
        run: headers,
    },
    Step {
        name: "build",
        title: "the executable, its plugins and all tests",
        help: "see the compiler's errors above; `cargo build --workspace --all-targets` shows them again",
        is_heavy: false,
        needs: &[],
        run: build,
    },
    Step {
        name: "lints",
        title: "clippy, warnings are errors",
        help: "see above; `cargo clippy --workspace --all-targets` shows them again",
        is_heavy: false,
        needs: &["build"],
        run: lints::run,
    },
    Step {
        name: "tests",
        title: "all tests, including those in the documentation",
        help: "see above; `cargo test -p <crate> <name>` runs one again",
        is_heavy: false,
        needs: &["build"],
        run: tests,
    },
    Step {
        name: "loom",
        title: "the cells of variables and the gate of calls, in every interleaving of their threads",
        help: "see above; the trace shows the interleaving that fails",
        is_heavy: true,
        needs: &["build"],
        run: loom,
    },
    Step {
        name: "valgrind",
        title: "memory errors in tables, plugins and cells, and instructions of the hot paths",
        help: "see above: the stack of an error, each line of which is in a test, or the path that takes more instructions",
        is_heavy: true,
        needs: &["build"],
        run: valgrind::run,
    },
    Step {
        name: "demo",
        title: "the demonstration gives identical decisions twice",
        help: "two runs of one seed must make the same decisions (R16); search for a clock, a hash map or a thread",
        is_heavy: true,
        needs: &["build"],
        run: demo::run,
    },
    Step {
        name: "parameters",
        title: "the page of parameters matches the plugins",
        help: "run `cargo xtask parameters` and review the changes",
        is_heavy: true,
        needs: &["build"],
        run: parameters::step,
    },
    Step {
        name: "peers",
        title: "independent programs drive the simulated robot and read recordings",
        help: "see the output of the client and the server above",
        is_heavy: true,
        needs: &["build"],
        run: peers::run,
    },
    Step {
        name: "ros2",
        title: "ROS 2 itself and jde drive each other's robots",
        help: "see the output of the programs of ROS 2 above",
        is_heavy: true,
        needs: &["build"],
        run: ros2::step,
    },
    Step {
        name: "python",
        title: "the Python package: its style, its types and its tests",
        help: "see above; `PYTHONPATH=target/python target/pytest/bin/python -m pytest programs/python` runs the tests again",
        is_heavy: true,
        needs: &["build"],
        run: pytest::run,
    },
    Step {
        name: "dask",
        title: "an experiment on a Dask cluster that loses a worker",
        help: "see target/clusters/dask/*.log: the scheduler, each worker, and the example that submits the parts",
        is_heavy: true,
        needs: &["build"],
        run: clusters::dask::run,
    },
    Step {
        name: "slurm",
        title: "an experiment as a Slurm job array, a task of which is killed",
        help: "see target/clusters/slurm/*.log: the daemons, each part, and the job that joins the parts",
        is_heavy: true,
        needs: &["build"],
        run: clusters::slurm::run,
    },
    Step {
        name: "tutorial",
        title: "the steps of docs/tutorial, with the output that they show",
        help: "see above what was printed: change the page, or what it describes; the files are in target/tutorial",
        is_heavy: true,
        needs: &["build"],
        run: tutorial::run,
    },
    Step {
        name: "packages",
        title: "packages, installed and removed in a fresh Debian without Rust",
        help: "see the output of the command above; the packages are in target/package, the Debian in target/package/root",
        is_heavy: true,
        needs: &["build"],
        run: package::trial::run,
    },
    Step {
        name: "manual",
        title: "the manual, and every link of it",
        help: "see the links above; `cargo xtask manual` builds it again",
        is_heavy: true,
        needs: &["build"],
        run: manual::step,
    },
    Step {
        name: "docs",
        title: "the documentation, warnings are errors",
        help: "see above; `cargo doc --workspace --no-deps` shows them again",
        is_heavy: true,
        needs: &["build"],
        run: docs,
    },
    Step {
        name: "extending",
        title: "the changes that docs/extending.md shows, in a copy of the project",
        help: "change the page with the code; `git diff` of a trial writes a new change",
        is_heavy: true,
        needs: &["build"],
        run: extending::run,
    },
];

/// Runs the chosen steps and prints a summary. The exit code is a failure if a step fails.
pub(crate) fn run(root: PathBuf, choice: &StepSelection, options: Options, paint: Paint) -> Result<ExitCode> {
    let target = Metadata::of_workspace(&root)?.target_directory;
    let ci = std::env::var("CI").is_ok_and(|value| !matches!(value.as_str(), "" | "0" | "false"));
    let context = Context {
        linting_compiler: lints::compiler()?,
        root,
        target,
        ci,
        options,
        paint,
    };
    let report = step::run_all(STEPS, &context, choice, paint);
    println!("{}", report.summary(paint));
    Ok(if report.has_failed() {
        ExitCode::FAILURE
    } else {
        ExitCode::SUCCESS
    })
}

/// The names that `--only` and `--skip` accept.
pub(crate) fn names() -> PossibleValuesParser {
    PossibleValuesParser::new(STEPS.iter().map(|step| step.name))
}

impl Context {
    #[cfg(test)]
    pub(crate) fn of_a_test(install: bool, ci: bool) -> Self {
        Self {
            root: PathBuf::new(),
            target: PathBuf::new(),
            ci,
            options: Options {
                install,
                ..Options::default()
            },
            paint: Paint::plain(),
            linting_compiler: None,
        }
    }

    pub(crate) fn has_lints(&self) -> bool {
        self.linting_compiler.is_some()
    }

    /// Returns the environment in which all steps share one build, which also lints.
    fn compiler(&self) -> Option<(&'static str, &PathBuf)> {
        let compiler = self.linting_compiler.as_ref();
        compiler.map(|compiler| ("RUSTC_WORKSPACE_WRAPPER", compiler))
    }

    /// Returns the arguments of cargo that select what to build and test.
    pub(crate) fn selection(&self) -> Vec<&str> {
        match &self.options.package {
            Some(package) => vec!["--package", package],
            None => Self::workspace(),
        }
    }

    /// Returns the arguments of cargo that select everything.
    pub(crate) fn workspace() -> Vec<&'static str> {
        let mut arguments = vec!["--workspace"];
        if prerequisites::has_libudev() {
            arguments.extend(["--features", "jde/gamepad"]);
        }
        arguments
    }

    /// Returns a `cargo` command in the root of the workspace.
    pub(crate) fn cargo(&self, arguments: &[&str]) -> Command {
        let mut cargo = shell::cargo();
        cargo.args(arguments).current_dir(&self.root);
        cargo.envs(self.compiler());
        if self.ci {
            // Incremental data would speed up the next build, but CI has none, and the data takes a fifth of
            // the disk space.
            cargo.env("CARGO_INCREMENTAL", "0");
        }
        cargo
    }

    /// Returns the outcome of a step that lacks a program: a failure in CI, otherwise a skip that the summary
    /// shows.
    pub(crate) fn missing_tool(&self, program: &str, how: &str) -> Result<StepOutcome> {
        if self.ci {
            bail!("{program} is not installed: {how}");
        }
        Ok(StepOutcome::Skipped(format!("{program} is not installed: {how}")))
    }

    /// Removes in CI a file or folder that no later step needs: the disk may be small, and nobody reads it there.
    pub(crate) fn discard(&self, path: &Path) -> Result<()> {
        let removed = match self.ci {
            false => Ok(()),
            true if path.is_dir() => fs::remove_dir_all(path),
            true => fs::remove_file(path),
        };
        match removed {
            Err(error) if error.kind() != io::ErrorKind::NotFound => {
                Err(error).with_context(|| format!("cannot remove {}", path.display()))
            }
            _ => Ok(()),
        }
    }

    fn run(&self, mut command: Command) -> Result<StepOutcome> {
        shell::run(&mut command, self.paint)?;
        Ok(StepOutcome::Passed)
    }
}

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
    for program in &programs {
        context.discard(program.path())?;
    }
    context.discard(&context.target.join("tmp"))?;
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

fn docs(context: &Context) -> Result<StepOutcome> {
    let mut cargo = context.cargo(&["doc", "--workspace", "--no-deps"]);
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

    #[test]
    fn what_no_step_needs_any_more_is_removed_only_in_ci() {
        let folder = tempfile::tempdir().unwrap();
        let (file, inner) = (folder.path().join("file"), folder.path().join("folder/inner"));
        fs::create_dir_all(&inner).unwrap();
        fs::write(&file, "").unwrap();
        let discard = |ci| {
            for path in [&file, inner.parent().unwrap(), &folder.path().join("none")] {
                Context::of_a_test(false, ci).discard(path).unwrap();
            }
            (file.exists(), inner.exists())
        };
        assert_eq!(discard(false), (true, true));
        assert_eq!(discard(true), (false, false));
    }

    #[test]
    fn a_missing_program_is_a_failure_only_in_ci() {
        let context = |ci| Context::of_a_test(false, ci);
        let error = context(true)
            .missing_tool("valgrind", "install it")
            .unwrap_err()
            .to_string();
        assert_eq!(error, "valgrind is not installed: install it");
        let done = context(false).missing_tool("valgrind", "install it").unwrap();
        assert_eq!(
            done,
            StepOutcome::Skipped("valgrind is not installed: install it".to_owned())
        );
    }
}
