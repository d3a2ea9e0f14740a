//! The command line: the verbs, their common options, and the exit status.
//!
//! A verb parses its options and calls the module that does the work. This module does no other work.

mod advice;
mod demo;
pub(crate) mod tools;
mod verbs;

use std::process::ExitCode;

use clap::{CommandFactory, FromArgMatches, Parser, Subcommand};
use clap_complete::CompleteEnv;
use jde_abi::raw;
use jde_session::cli::{Common, exit_status, report_usage_error};
use jde_terminal as terminal;

use crate::failure::Failure;

/// Run robots by schemas: small periodic tasks that compete to act, arranged in a hierarchy.
#[derive(Parser)]
#[command(
    name = "jde",
    version,
    long_version = long_version(),
    arg_required_else_help = true,
    subcommand_required = true,
    after_help = "Begin with:
  jde demo                   watch a simulated robot find its way through a building
  jde new schema follow      write a schema of your own

Exit status: 0 done, 1 the mission failed, 2 wrong use or application file, 3 a plugin is missing or unusable."
)]
struct Cli {
    #[command(subcommand)]
    verb: Verb,
    #[command(flatten)]
    common: Common,
}

/// The versions of everything that must fit between two builds: plugins the ABI, tools the link.
fn long_version() -> String {
    let version = env!("CARGO_PKG_VERSION");
    let abi = format!("{}.{}", raw::ABI_MAJOR, raw::ABI_MINOR);
    format!(
        "{version}\nplugin ABI {abi}\nlink protocol {}",
        jde_link::PROTOCOL
    )
}

#[derive(Subcommand)]
enum Verb {
    Demo(demo::LinkedDemo),
    #[command(flatten)]
    Tool(Box<tools::Tool>),
}

/// Parses the command line, runs the verb and returns the exit status.
pub(crate) fn main() -> ExitCode {
    // A shell requests completions through an environment variable. This call replies to the request and
    // exits.
    CompleteEnv::with_factory(Cli::command).complete();
    let Cli { verb, common } = match verbs::group_verbs(Cli::command())
        .try_get_matches()
        .and_then(|matches| Cli::from_arg_matches(&matches))
    {
        Ok(cli) => cli,
        Err(mut error) => {
            advice::advise(&mut error);
            return report_usage_error(&error);
        }
    };
    terminal::set_color(common.color);
    let result = match verb {
        Verb::Demo(demo) => demo.run(common.log),
        Verb::Tool(tool) => tool.run(common.log),
    };
    exit_status(result, Failure::report)
}
