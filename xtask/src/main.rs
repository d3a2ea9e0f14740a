//! Automation of this workspace: `cargo xtask <verb>` does the same locally and in CI. It builds, tests and
//! checks. It is not part of the product.

mod agents;
mod bench;
mod browser;
mod clients;
mod clusters;
mod counts;
mod demo;
mod disk_space;
mod extending;
mod faults;
mod foxglove;
mod headers;
mod lints;
mod manual;
mod metadata;
mod mujoco;
mod package;
mod paint;
mod parameters;
mod peers;
mod player;
mod prerequisites;
mod programs;
mod project_files;
mod pytest;
mod python;
mod release;
mod ros2;
mod shell;
mod step;
mod steps;
mod test;
mod tidy;
mod tutorial;
mod valgrind;

use std::path::PathBuf;
use std::process::ExitCode;

use anyhow::Result;
use clap::{Args, Parser, Subcommand};

use crate::paint::Paint;

/// Automation of this workspace.
#[derive(Parser)]
#[command(name = "cargo xtask", bin_name = "cargo xtask", disable_version_flag = true)]
struct Cli {
    #[command(subcommand)]
    verb: Verb,
}

#[derive(Subcommand)]
enum Verb {
    /// Run the tests, from a fresh checkout; report first which tools are missing, and how to install them.
    Test(Test),
    /// Check what the compiler cannot see: dependencies, headers, lengths, links, licences, ...
    Tidy,
    /// Renew the C headers under include/ from the Rust source.
    Headers {
        /// Only print which headers differ.
        #[arg(long)]
        check: bool,
    },
    /// Renew docs/parameters.md, our parameters beside those of others, from the development build.
    Parameters,
    /// Count the instructions of the hot paths, and compare them with the expected counts.
    Counts {
        /// Save these counts as the expected ones.
        #[arg(long)]
        renew: bool,
    },
    /// Measure jde against the best alternatives in the same run, and print one table (docs/figures/performance.md).
    Bench(bench::Choice),
    /// Make packages for machines without Rust, under target/package (docs/installing.md).
    Package(package::Choice),
    /// Make a release: versions, packages, sums, a list of contents; uploads nothing (docs/releases.md).
    Release(release::Release),
    /// Build the manual, the pages of docs and a reference, under target/manual; it needs mdbook.
    Manual,
    /// Inject faults into running applications, and check that the rules still hold; `--help` prints the
    /// options.
    #[command(disable_help_flag = true)]
    Faults(Faults),
}

#[derive(Args)]
struct Faults {
    /// Use the development build instead of the optimised one.
    #[arg(long)]
    dev: bool,
    /// The arguments of the campaign.
    #[arg(trailing_var_arg = true, allow_hyphen_values = true)]
    arguments: Vec<std::ffi::OsString>,
}

#[derive(Args)]
#[command(after_help = "Examples:
  cargo xtask test              format, lints and tests
  cargo xtask test --all        also model checks, memory checks, the demonstration, independent programs, documentation
  cargo xtask test -p jde-link  lints and tests of one package
  cargo xtask test --only tidy")]
struct Test {
    /// Run the heavy steps too, as CI does.
    #[arg(long)]
    all: bool,
    /// Only lint and test this package.
    #[arg(long, short, value_name = "PACKAGE", conflicts_with_all = ["all", "only"])]
    package: Option<String>,
    /// Install missing tools with apt-get and rustup. In CI (`CI=true`) root does so by default.
    #[arg(long)]
    install: bool,
    /// Stop at the first step that fails.
    #[arg(long)]
    fail_fast: bool,
    /// Run only this step (may be repeated).
    #[arg(long, value_name = "STEP", value_parser = test::names())]
    only: Vec<String>,
    /// Skip this step (may be repeated).
    #[arg(long, value_name = "STEP", value_parser = test::names())]
    skip: Vec<String>,
}

/// The root of the workspace: the folder above this package.
fn root() -> PathBuf {
    // Cargo passes the package's folder at run time. The built-in value serves when the program is started
    // directly.
    let package = std::env::var_os("CARGO_MANIFEST_DIR").unwrap_or_else(|| env!("CARGO_MANIFEST_DIR").into());
    let mut root = PathBuf::from(package);
    root.pop();
    root
}

fn main() -> ExitCode {
    let outcome = run(Cli::parse().verb);
    outcome.unwrap_or_else(|error| {
        eprintln!("error: {error:#}");
        ExitCode::FAILURE
    })
}

fn run(verb: Verb) -> Result<ExitCode> {
    let root = root();
    let paint = Paint::detect();
    match verb {
        Verb::Test(Test {
            all,
            package,
            install,
            fail_fast,
            mut only,
            skip,
        }) => {
            if package.is_some() {
                only = vec!["lints".to_owned(), "tests".to_owned()];
            }
            let choice = step::StepSelection {
                fail_fast,
                all,
                only,
                skip,
            };
            let options = test::Options { install, package };
            return test::run(root, &choice, options, paint);
        }
        Verb::Tidy => tidy::run(&root)?,
        Verb::Headers { check: false } => headers::renew(&root)?,
        Verb::Headers { check: true } => headers::check(&root)?,
        Verb::Parameters => parameters::renew(&root)?,
        Verb::Counts { renew: false } => counts::check(&root, paint)?,
        Verb::Counts { renew: true } => counts::renew(&root, paint)?,
        Verb::Bench(choice) => return bench::run(&root, &choice, paint),
        Verb::Manual => manual::run(&root, paint)?,
        Verb::Package(choice) => package::run(&root, &choice, paint)?,
        Verb::Release(choice) => release::run(&root, &choice, paint)?,
        Verb::Faults(Faults { dev, arguments }) => return faults::run(&root, dev, &arguments, paint),
    }
    Ok(ExitCode::SUCCESS)
}

#[cfg(test)]
mod tests {
    use clap::CommandFactory as _;

    use super::*;

    #[test]
    fn the_command_line_is_consistent() {
        Cli::command().debug_assert();
    }

    #[test]
    fn the_root_contains_the_workspace() {
        let manifest = std::fs::read_to_string(root().join("Cargo.toml")).unwrap();
        assert!(manifest.contains("[workspace]"));
    }

    #[test]
    fn the_arguments_of_the_campaign_are_passed_unchanged() {
        let cli = Cli::try_parse_from(["xtask", "faults", "--dev", "--seed", "7", "--help"]).unwrap();
        let Verb::Faults(Faults { dev, arguments }) = cli.verb else {
            panic!("another verb");
        };
        assert!(dev);
        assert_eq!(arguments, ["--seed", "7", "--help"]);
        assert!(Cli::try_parse_from(["xtask", "faults", "--help"]).is_ok());
    }

    #[test]
    fn an_unknown_step_is_refused() {
        assert!(Cli::try_parse_from(["xtask", "test", "--only", "fmt"]).is_ok());
        assert!(Cli::try_parse_from(["xtask", "test", "--skip", "nothing"]).is_err());
    }
}
