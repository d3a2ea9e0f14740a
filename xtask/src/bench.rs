//! Builds the benches and everything that they measure, and runs them. The benches are a separate workspace,
//! so that the programs they compare jde with never enter its build. The benches themselves define the
//! measurements.

use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode, Stdio};

use anyhow::{Context as _, Result, bail};
use clap::Args;

use crate::metadata::Metadata;
use crate::paint::Paint;
use crate::{ros2, shell};

/// The folder of the benches.
const FOLDER: &str = "benches";

/// The files with the figures and with the page that shows them.
const TABLE: &str = "benches/table.json";
const PAGE: &str = "docs/figures/performance.md";
/// The page with the figures of ROS 2, and the sources of the programs that they are compared with.
const ROS2_PAGE: &str = "docs/figures/ros2.md";
const ROS2_PEERS: &str = "benches/peers/ros2";

/// The Python package that the rows of [`COMPARED_ROWS`] compare with.
const PACKAGE: &str = "ir-sim==2.12.0";
const IMPORT: &str = "import irsim";
const COMPARED_ROWS: [&str; 2] = ["experiment", "laser"];

/// The options of a measurement.
#[derive(Args)]
pub(crate) struct Choice {
    /// Measure only this row (may be repeated).
    #[arg(long, value_name = "NAME")]
    row: Vec<String>,
    /// Only print the names of the rows.
    #[arg(long)]
    list: bool,
    /// Measure the drivers of ROS 2 beside programs of ROS 2 instead, if it is sourced.
    #[arg(long)]
    ros2: bool,
    /// Take a tenth of the time, for less reliable figures.
    #[arg(long)]
    quick: bool,
    /// Save the table and the description of the machine as JSON. Without a name, write benches/table.json
    /// and the table in docs/figures/performance.md.
    #[arg(long, value_name = "FILE", num_args = 0..=1)]
    save: Option<Option<PathBuf>>,
}

/// Builds and measures. Returns the exit status of the benches.
pub(crate) fn run(root: &Path, choice: &Choice, paint: Paint) -> Result<ExitCode> {
    choice.check()?;
    let target = Metadata::of_workspace(root)?.target_directory;
    if choice.ros2 {
        return run_ros2(root, &target, choice, paint);
    }
    if !choice.list {
        shell::run(
            shell::cargo()
                .args(["build", "--release", "--workspace"])
                .current_dir(root),
            paint,
        )?;
    }
    shell::run(build(root, &target).arg("--workspace"), paint)?;
    let built = target.join("release");
    let mut benches = Command::new(built.join("jde-benches"));
    benches.args(choice.arguments());
    benches.args(choice.saved(root, &std::env::current_dir()?));
    benches.arg("--root").arg(root).arg("--built").arg(&built);
    if !choice.list && choice.needs_python() {
        match python(&target, paint) {
            Ok(python) => _ = benches.arg("--python").arg(python),
            Err(error) if choice.keeps_all() => {
                return Err(error.context(format!("cannot install {PACKAGE}")));
            }
            // Few rows compare with the package, and they have other lines too.
            Err(error) => println!("{PACKAGE} is omitted: {error:#}"),
        }
    }
    measure(&mut benches, paint)
}

/// Builds the drivers of ROS 2 and what they are compared with, and measures them.
fn run_ros2(root: &Path, target: &Path, choice: &Choice, paint: Paint) -> Result<ExitCode> {
    let (built, peers) = (target.join("release"), target.join("bench-peers/ros2"));
    if !choice.list {
        if !ros2::is_sourced() {
            println!("skipped: {}", ros2::NOT_SOURCED);
            return Ok(ExitCode::SUCCESS);
        }
        let mut product = shell::cargo();
        product.args(["build", "--release", "-p", "jde", "-p", "ros2"]);
        shell::run(product.current_dir(root), paint)?;
        let mut cmake = Command::new("cmake");
        cmake.arg("-S").arg(root.join(ROS2_PEERS)).arg("-B").arg(&peers);
        shell::run(&mut cmake, paint)?;
        shell::run(Command::new("cmake").arg("--build").arg(&peers), paint)?;
    }
    let packages = ["-p", "jde-bench-ros2", "-p", "jde-bench-plugin"];
    shell::run(build(root, target).args(packages), paint)?;
    let mut benches = Command::new(built.join("jde-bench-ros2"));
    benches.args(choice.arguments());
    benches.arg("--root").arg(root).arg("--built").arg(&built);
    benches.arg("--peers").arg(&peers);
    if choice.save.is_some() {
        benches.arg("--page").arg(root.join(ROS2_PAGE));
    }
    measure(&mut benches, paint)
}

/// Starts the benches. Returns their exit status.
fn measure(benches: &mut Command, paint: Paint) -> Result<ExitCode> {
    benches.stdin(Stdio::null());
    shell::show(benches, paint);
    let status = benches.status().context("cannot start the benches")?;
    Ok(if status.success() {
        ExitCode::SUCCESS
    } else {
        ExitCode::FAILURE
    })
}

/// Builds into the product's target folder, since most libraries are the same.
fn build(root: &Path, target: &Path) -> Command {
    let mut cargo = shell::cargo();
    cargo
        .args(["build", "--release", "--target-dir"])
        .arg(target)
        .current_dir(root.join(FOLDER));
    cargo
}

/// Returns a Python interpreter in its own environment, in which the package is installed.
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
    /// Returns whether a row that compares with the package is measured.
    fn needs_python(&self) -> bool {
        self.row.is_empty() || self.row.iter().any(|row| COMPARED_ROWS.contains(&row.as_str()))
    }

    /// Returns whether the table of the project is replaced.
    fn keeps_all(&self) -> bool {
        matches!(self.save, Some(None))
    }

    /// Checks that the project's table is only replaced by a complete one of full effort.
    fn check(&self) -> Result<()> {
        if self.ros2 && matches!(self.save, Some(Some(_))) {
            bail!("with `--ros2`, `--save` replaces the table in {ROS2_PAGE} and takes no file");
        }
        if self.keeps_all() && (self.quick || !self.row.is_empty()) {
            bail!(
                "`--save` alone replaces the whole table; to save another one, name a file, as in `--save some.json`"
            );
        }
        Ok(())
    }

    /// Returns the arguments that all benches have.
    fn arguments(&self) -> Vec<&str> {
        let rows = self.row.iter().flat_map(|row| ["--row", row]);
        let flags = [("--list", self.list), ("--quick", self.quick)];
        let flags = flags.into_iter().filter(|(_, given)| *given);
        rows.chain(flags.map(|(flag, _)| flag)).collect()
    }

    /// Returns the arguments for what is saved, with absolute paths because the benches run in another folder.
    fn saved(&self, root: &Path, current: &Path) -> Vec<PathBuf> {
        let saved = self.save.iter().flat_map(|file| match file {
            Some(file) => vec!["--save".into(), current.join(file)],
            None => vec![
                "--save".into(),
                root.join(TABLE),
                "--page".into(),
                root.join(PAGE),
            ],
        });
        saved.collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn choice(row: &[&str], quick: bool, save: Option<Option<&str>>) -> Choice {
        Choice {
            row: row.iter().map(|row| (*row).to_owned()).collect(),
            list: false,
            ros2: false,
            quick,
            save: save.map(|file| file.map(PathBuf::from)),
        }
    }

    #[test]
    fn the_options_are_passed_to_the_benches() {
        let some = choice(&["read", "demo"], true, Some(Some("some.json")));
        let saved = |choice: &Choice| choice.saved(Path::new("root"), Path::new("current"));
        assert_eq!(some.arguments(), ["--row", "read", "--row", "demo", "--quick"]);
        assert_eq!(saved(&some), ["--save", "current/some.json"].map(PathBuf::from));
        let expected = [
            "--save",
            "root/benches/table.json",
            "--page",
            "root/docs/figures/performance.md",
        ];
        assert_eq!(
            saved(&choice(&[], false, Some(None))),
            expected.map(PathBuf::from)
        );
    }

    #[test]
    fn only_a_complete_measurement_replaces_the_table_of_the_project() {
        assert!(choice(&[], false, Some(None)).check().is_ok());
        assert!(choice(&["read"], false, Some(None)).check().is_err());
        assert!(choice(&[], true, Some(None)).check().is_err());
        assert!(choice(&["read"], true, Some(Some("some.json"))).check().is_ok());
        assert!(choice(&["read"], true, None).check().is_ok());
        let of_ros2 = |save| Choice {
            ros2: true,
            ..choice(&[], false, Some(save))
        };
        assert!(of_ros2(None).check().is_ok());
        assert!(of_ros2(Some("some.json")).check().is_err());
    }
}
