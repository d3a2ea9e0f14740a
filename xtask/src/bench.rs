//! Builds the benches and all that they measure, and has them measure it. They are a workspace of their own, so that what jde is
//! compared with never enters its build; what they measure and how is theirs to say.

use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode, Stdio};

use anyhow::{Context as _, Result, bail};
use clap::Args;

use crate::metadata::Metadata;
use crate::paint::Paint;
use crate::shell;

/// Where they are.
const FOLDER: &str = "benches";

/// Where their figures are kept, and shown.
const TABLE: &str = "benches/table.json";
const PAGE: &str = "docs/performance.md";

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
    /// Keep the table and what machine this is in a file of JSON; without a name in benches/table.json, and the table in
    /// docs/performance.md too.
    #[arg(long, value_name = "FILE", num_args = 0..=1)]
    save: Option<Option<PathBuf>>,
}

/// Builds and measures; its exit status is that of the benches.
pub(crate) fn run(root: &Path, choice: &Choice, paint: Paint) -> Result<ExitCode> {
    choice.check()?;
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
    benches.args(choice.arguments(root, &std::env::current_dir()?));
    benches.arg("--root").arg(root).arg("--built").arg(&built);
    if !choice.list && choice.casts_rays() {
        match python(&target, paint) {
            Ok(python) => _ = benches.arg("--python").arg(python),
            Err(error) if choice.keeps_all() => {
                return Err(error.context(format!("cannot install {PACKAGE}")));
            }
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

    /// Whether the table of the project is to be replaced.
    fn keeps_all(&self) -> bool {
        matches!(self.save, Some(None))
    }

    /// The table of the project is whole, and worth its figures.
    fn check(&self) -> Result<()> {
        if self.keeps_all() && (self.quick || !self.row.is_empty()) {
            bail!(
                "`--save` alone keeps the whole table: name a file, as in `--save some.json`, to keep another"
            );
        }
        Ok(())
    }

    /// As the benches want it, who run elsewhere than here.
    fn arguments(&self, root: &Path, here: &Path) -> Vec<PathBuf> {
        let rows = self.row.iter().flat_map(|row| ["--row", row]).map(PathBuf::from);
        let flags = [("--list", self.list), ("--quick", self.quick)];
        let flags = flags.into_iter().filter(|(_, given)| *given);
        let save = self.save.iter().flat_map(|file| match file {
            Some(file) => vec!["--save".into(), here.join(file)],
            None => vec![
                "--save".into(),
                root.join(TABLE),
                "--page".into(),
                root.join(PAGE),
            ],
        });
        rows.chain(flags.map(|(flag, _)| flag.into()))
            .chain(save)
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn choice(row: &[&str], quick: bool, save: Option<Option<&str>>) -> Choice {
        Choice {
            row: row.iter().map(|row| (*row).to_owned()).collect(),
            list: false,
            quick,
            save: save.map(|file| file.map(PathBuf::from)),
        }
    }

    #[test]
    fn what_is_chosen_is_handed_on() {
        let some = choice(&["read", "demo"], true, Some(Some("kept.json")));
        let expected = [
            "--row",
            "read",
            "--row",
            "demo",
            "--quick",
            "--save",
            "here/kept.json",
        ];
        let arguments = |choice: &Choice| choice.arguments(Path::new("root"), Path::new("here"));
        assert_eq!(arguments(&some), expected.map(PathBuf::from));
        let expected = [
            "--save",
            "root/benches/table.json",
            "--page",
            "root/docs/performance.md",
        ];
        assert_eq!(
            arguments(&choice(&[], false, Some(None))),
            expected.map(PathBuf::from)
        );
    }

    #[test]
    fn the_table_of_the_project_is_kept_whole_or_not_at_all() {
        assert!(choice(&[], false, Some(None)).check().is_ok());
        assert!(choice(&["read"], false, Some(None)).check().is_err());
        assert!(choice(&[], true, Some(None)).check().is_err());
        assert!(choice(&["read"], true, Some(Some("some.json"))).check().is_ok());
        assert!(choice(&["read"], true, None).check().is_ok());
    }
}
