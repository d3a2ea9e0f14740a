//! Automation of this workspace: `cargo xtask <verb>`, the same at hand and in CI. It builds, tests and checks;
//! it is no part of what users get.

mod bench;
mod cargo_json;
mod clients;
mod counts;
mod demo;
mod faults;
mod headers;
mod metadata;
mod paint;
mod peers;
mod prerequisites;
mod room;
mod ros2;
mod shell;
mod step;
mod test;
mod tidy;
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
    /// Run every test there is, from a fresh checkout; what the machine lacks is told first, and how to install it.
    Test(Test),
    /// Check what the compiler cannot see: arrows, headers, lengths, links, licences, ...
    Tidy,
    /// Renew the C headers under include/ from the Rust they describe.
    Headers {
        /// Only say which of them differ.
        #[arg(long)]
        check: bool,
    },
    /// Count the instructions of the hot paths, and hold them against those that are kept.
    Counts {
        /// Keep what is counted now.
        #[arg(long)]
        renew: bool,
    },
    /// Measure jde against the best there is, in the same run, and print one table (docs/performance.md).
    Bench(bench::Choice),
    /// Inject faults into running applications, and see that the rules hold all the same; `--help` tells more.
    #[command(disable_help_flag = true)]
    Faults(Faults),
}

#[derive(Args)]
struct Faults {
    /// The build for development instead of the optimised one.
    #[arg(long)]
    dev: bool,
    /// What the campaign is told.
    #[arg(trailing_var_arg = true, allow_hyphen_values = true)]
    words: Vec<std::ffi::OsString>,
}

#[derive(Args)]
struct Test {
    /// Install what the machine lacks, with apt-get and rustup. Root does so unasked where `CI=true`, and nobody else.
    #[arg(long)]
    install: bool,
    /// Stop at the first step that fails.
    #[arg(long)]
    fail_fast: bool,
    /// Run this step alone (may be repeated).
    #[arg(long, value_name = "STEP", value_parser = test::names())]
    only: Vec<String>,
    /// Leave this step out (may be repeated).
    #[arg(long, value_name = "STEP", value_parser = test::names())]
    skip: Vec<String>,
}

/// The root of the workspace: the folder above this package.
fn root() -> PathBuf {
    // Cargo says where the package is when it runs us; the built-in value serves a program started by hand.
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
            install,
            fail_fast,
            only,
            skip,
        }) => {
            let choice = step::Choice {
                fail_fast,
                only,
                skip,
            };
            return test::run(root, &choice, install, paint);
        }
        Verb::Tidy => tidy::run(&root)?,
        Verb::Headers { check: false } => headers::renew(&root)?,
        Verb::Headers { check: true } => headers::check(&root)?,
        Verb::Counts { renew: false } => counts::check(&root, paint)?,
        Verb::Counts { renew: true } => counts::renew(&root, paint)?,
        Verb::Bench(choice) => return bench::run(&root, &choice, paint),
        Verb::Faults(Faults { dev, words }) => return faults::run(&root, dev, &words, paint),
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
    fn the_root_holds_the_workspace() {
        let manifest = std::fs::read_to_string(root().join("Cargo.toml")).unwrap();
        assert!(manifest.contains("[workspace]"));
    }

    #[test]
    fn what_the_campaign_is_told_reaches_it_as_it_was_typed() {
        let cli = Cli::try_parse_from(["xtask", "faults", "--dev", "--seed", "7", "--help"]).unwrap();
        let Verb::Faults(Faults { dev, words }) = cli.verb else {
            panic!("another verb");
        };
        assert!(dev);
        assert_eq!(words, ["--seed", "7", "--help"]);
        assert!(Cli::try_parse_from(["xtask", "faults", "--help"]).is_ok());
    }

    #[test]
    fn an_unknown_step_is_refused() {
        assert!(Cli::try_parse_from(["xtask", "test", "--only", "fmt"]).is_ok());
        assert!(Cli::try_parse_from(["xtask", "test", "--skip", "nothing"]).is_err());
    }
}
