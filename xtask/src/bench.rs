//! Builds the benches and all that they measure, and has them measure it. They are a workspace of their own, so that what jde is
//! compared with never enters its build; what they measure and how is theirs to say.

use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode, Stdio};

use anyhow::{Context as _, Result};
use clap::Args;

use crate::metadata::Metadata;
use crate::paint::Paint;
use crate::shell;

/// Where they are.
const FOLDER: &str = "benches";

/// What they are compared with that is written in Python.
const PACKAGE: &str = "ir-sim==2.12.0";
const IMPORT: &str = "import irsim";

/// What to measure.
#[derive(Args)]
pub(crate) struct Choice {
    /// Measure this row alone (may be repeated).
    #[arg(long, value_name = "NAME")]
    row: Vec<String>,
    /// Only say which rows there are.
    #[arg(long)]
    list: bool,
    /// A look: a tenth of the time, and figures that are worth less.
    #[arg(long)]
    quick: bool,
    /// Keep the table and what machine this is in a file of JSON.
    #[arg(long, value_name = "FILE", num_args = 0..=1, default_missing_value = "benches/table.json")]
    save: Option<PathBuf>,
}

/// Builds and measures; its exit status is that of the benches.
pub(crate) fn run(root: &Path, choice: &Choice, paint: Paint) -> Result<ExitCode> {
    let target = Metadata::of_workspace(root)?.target_directory;
    if !choice.list {
        shell::run(
            shell::cargo().args(["build", "--release"]).current_dir(root),
            paint,
        )?;
    }
    shell::run(&mut build(root, &target), paint)?;
    let built = target.join("release");
    let mut benches = Command::new(built.join("jde-benches"));
    benches.args(choice.arguments(&std::env::current_dir()?));
    benches.arg("--root").arg(root).arg("--built").arg(&built);
    if !choice.list && choice.casts_rays() {
        match python(&target, paint) {
            Ok(python) => _ = benches.arg("--python").arg(python),
            // One yardstick of one row: the others need no Python.
            Err(error) => println!("{PACKAGE} is left out: {error:#}"),
        }
    }
    benches.stdin(Stdio::null());
    shell::show(&benches, paint);
    let status = benches.status().context("cannot start the benches")?;
    Ok(if status.success() {
        ExitCode::SUCCESS
    } else {
        ExitCode::FAILURE
    })
}

/// Into the same folder as the product: most libraries are the same.
fn build(root: &Path, target: &Path) -> Command {
    let mut cargo = shell::cargo();
    cargo
        .args(["build", "--release", "--workspace", "--target-dir"])
        .arg(target)
        .current_dir(root.join(FOLDER));
    cargo
}

/// A Python of its own that has the package.
fn python(target: &Path, paint: Paint) -> Result<PathBuf> {
    let folder = target.join("bench-peers");
    let python = folder.join("bin/python");
    if !shell::succeeds(Command::new(&python).args(["-c", IMPORT])) {
        let mut venv = Command::new("python3");
        shell::run(venv.args(["-m", "venv", "--clear"]).arg(&folder), paint)?;
        let mut pip = Command::new(&python);
        shell::run(pip.args(["-m", "pip", "install", "--quiet", PACKAGE]), paint)?;
    }
    Ok(python)
}

impl Choice {
    /// Whether the row is to be measured that the package is for.
    fn casts_rays(&self) -> bool {
        self.row.is_empty() || self.row.iter().any(|row| row == "laser")
    }

    /// As the benches want it, who run elsewhere than here.
    fn arguments(&self, here: &Path) -> Vec<PathBuf> {
        let rows = self.row.iter().flat_map(|row| ["--row", row]).map(PathBuf::from);
        let flags = [("--list", self.list), ("--quick", self.quick)];
        let flags = flags.into_iter().filter(|(_, given)| *given);
        let save = self
            .save
            .iter()
            .flat_map(|file| ["--save".into(), here.join(file)]);
        rows.chain(flags.map(|(flag, _)| flag.into()))
            .chain(save)
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_chosen_is_handed_on() {
        let choice = Choice {
            row: vec!["read".to_owned(), "demo".to_owned()],
            list: false,
            quick: true,
            save: Some("kept.json".into()),
        };
        let expected = [
            "--row",
            "read",
            "--row",
            "demo",
            "--quick",
            "--save",
            "here/kept.json",
        ];
        assert_eq!(choice.arguments(Path::new("here")), expected.map(PathBuf::from));
    }
}
