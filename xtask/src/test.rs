//! `cargo xtask test`: runs the [`steps`](crate::steps), each with this context.

use std::fs::File;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};
use std::{fs, io};

use anyhow::{Context as _, Result, bail};
use clap::builder::PossibleValuesParser;

use crate::metadata::Metadata;
use crate::paint::Paint;
use crate::step::{self, StepOutcome, StepSelection};
use crate::steps::STEPS;
use crate::{lints, shell};

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
    /// The only package to lint and to test.
    pub(crate) package: Option<String>,
}

/// The variable of cargo that names the compiler of the packages of a workspace.
pub(crate) const LINTING_COMPILER: &str = "RUSTC_WORKSPACE_WRAPPER";

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
    pub(crate) fn compiler(&self) -> Option<(&'static str, &PathBuf)> {
        let compiler = self.linting_compiler.as_ref();
        compiler.map(|compiler| (LINTING_COMPILER, compiler))
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
        vec!["--workspace"]
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

    /// Removes in CI what a folder contains. The folder stays: cargo promises it to the programs that run again.
    pub(crate) fn clear(&self, folder: &Path) -> Result<()> {
        self.discard(folder)?;
        fs::create_dir_all(folder).with_context(|| format!("cannot create {}", folder.display()))
    }

    /// Empties in CI a program that no later step runs. It stays, and its time: a missing one cargo would build again.
    pub(crate) fn empty(&self, program: &Path) -> Result<()> {
        if !self.ci {
            return Ok(());
        }
        let file = File::options().write(true).open(program)?;
        let time = file.metadata()?.modified()?;
        file.set_len(0)?;
        file.set_modified(time)
            .with_context(|| format!("cannot empty {}", program.display()))
    }

    pub(crate) fn run(&self, mut command: Command) -> Result<StepOutcome> {
        shell::run(&mut command, self.paint)?;
        Ok(StepOutcome::Passed)
    }
}

#[cfg(test)]
mod tests {
    use std::time::{Duration, SystemTime};

    use super::*;

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
    fn a_folder_is_cleared_only_in_ci_and_stays() {
        let target = tempfile::tempdir().unwrap();
        let folder = target.path().join("tmp");
        let kept = |ci| {
            fs::create_dir_all(folder.join("of_a_test")).unwrap();
            Context::of_a_test(false, ci).clear(&folder).unwrap();
            fs::read_dir(&folder).unwrap().count()
        };
        assert_eq!((kept(false), kept(true)), (1, 0));
    }

    #[test]
    fn a_program_is_emptied_only_in_ci_and_keeps_its_time() {
        let folder = tempfile::tempdir().unwrap();
        let program = folder.path().join("program");
        fs::write(&program, "code").unwrap();
        let long_ago = SystemTime::UNIX_EPOCH + Duration::from_secs(1000);
        let file = File::options().write(true).open(&program).unwrap();
        file.set_modified(long_ago).unwrap();
        for (ci, bytes) in [(false, 4), (true, 0)] {
            Context::of_a_test(false, ci).empty(&program).unwrap();
            let found = fs::metadata(&program).unwrap();
            assert_eq!((found.len(), found.modified().unwrap()), (bytes, long_ago));
        }
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
