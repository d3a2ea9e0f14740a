//! The command line: the verbs, their common options, and the exit status.
//!
//! A verb parses its options and calls the module that does the work. This module does no other work.

pub(crate) mod clock;
mod demo;
#[cfg(feature = "tools")]
pub(crate) mod tools;
mod verbs;

use std::io::{self, Write};
use std::process::ExitCode;

use clap::{CommandFactory, FromArgMatches, Parser, Subcommand};
use clap_complete::CompleteEnv;
use jde_abi::raw;
use jde_files::is_control;

use crate::escape::escape_json;
use crate::failure::Failure;
use crate::load::LoadedApplication;
use crate::log::{Filter, Log};
use crate::session::Finished;
use crate::summary::{self, RunSummary};
use crate::terminal::{self, Color, own_styles};

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

Exit status: 0 done, 1 the mission failed, 2 wrong use or application file, 3 a plugin."
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
    let text = format!("{version}\nplugin ABI {}.{}", raw::ABI_MAJOR, raw::ABI_MINOR);
    #[cfg(feature = "tools")]
    let text = format!("{text}\nlink protocol {}", jde_link::PROTOCOL);
    text
}

/// Options common to all verbs.
#[derive(clap::Args)]
struct Common {
    /// When to use colours.
    #[arg(long, global = true, value_enum, default_value_t, value_name = "WHEN")]
    color: Color,
    /// The part of the log to show on standard error: LEVEL, SCHEMA=LEVEL, or state=LEVEL for changes of
    /// state; separate several with commas. Levels: off, error, warn (the default), info, debug, trace.
    #[arg(long, global = true, value_name = "FILTER", value_parser = clap::value_parser!(Filter))]
    log: Option<Filter>,
}

#[derive(Subcommand)]
enum Verb {
    Demo(demo::Demo),
    #[cfg(feature = "tools")]
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
        Err(error) => return report_usage_error(&error),
    };
    terminal::set_color(common.color);
    let result = match verb {
        Verb::Demo(demo) => demo.run(common.log),
        #[cfg(feature = "tools")]
        Verb::Tool(tool) => tool.run(common.log),
    };
    exit_status(result)
}

/// Returns the exit status after all printed output has been written, or its reader has stopped reading.
fn exit_status(result: Result<(), Failure>) -> ExitCode {
    let drained = terminal::drain();
    let status = match result.and(drained.map_err(Failure::from)) {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => failure.report(),
    };
    // Flushes the error report. A failure of this flush cannot be reported anywhere.
    let _ = terminal::drain();
    status
}

/// Prints a clap message: help and version to standard output with status 0, wrong use to standard error with
/// status 2.
fn report_usage_error(error: &clap::Error) -> ExitCode {
    print_help(error);
    let _ = terminal::drain();
    ExitCode::from(u8::from(error.use_stderr()) * 2)
}

/// Prints clap's own output: help, the version, or the description of wrong use.
fn print_help(error: &clap::Error) {
    let mut output = if error.use_stderr() {
        terminal::err()
    } else {
        terminal::out()
    };
    let text = error.render();
    // An argument may contain escape sequences of others. Then the text has no style.
    let text = match text.to_string() {
        plain if plain.contains(|letter| letter != '\n' && is_control(letter)) => plain,
        _ => own_styles(&text.ansi().to_string()),
    };
    // A closed pipe is not an error.
    let _ = output.write_all(text.as_bytes());
}

/// Starts the log of a run, after checking the filter against the application's schemas.
fn start_log(filter: Option<Filter>, loaded: &LoadedApplication) -> Result<Log, Failure> {
    let filter = filter.unwrap_or_default();
    let names = loaded
        .application
        .instances
        .iter()
        .map(|instance| instance.name.as_str());
    filter
        .check(names)
        .map_err(|(message, help)| Failure::usage(message, help))?;
    Ok(Log::start(filter))
}

/// Prints the summary of a run as text, and if requested as one JSON object in the last line of standard
/// output.
fn conclude(
    finished: Finished,
    last_lines: &str,
    json: bool,
    fulfilled: impl Fn(&RunSummary) -> bool,
) -> Result<(), Failure> {
    let Finished { summary, mut output } = finished;
    summary::print_summary(&summary, &mut output)?;
    output.write_all(last_lines.as_bytes())?;
    output.flush()?;
    if json {
        print_json(&summary)?;
    }
    if !fulfilled(&summary) {
        return Err(Failure::Mission);
    }
    if summary.late_takeovers() > 0 {
        return Err(Failure::Contract);
    }
    summary
        .recording
        .map_or(Ok(()), |recorded| recorded.check_complete())?;
    match summary.unwritten.as_slice() {
        [] => Ok(()),
        files => Err(Failure::Broken(files.join("; "))),
    }
}

/// Prints a value on standard output: as one line of JSON, or as the text that `write` makes of it.
pub(crate) fn print_value<T: serde::Serialize>(
    json: bool,
    value: &T,
    write: impl FnOnce(&T, &mut dyn Write) -> io::Result<()>,
) -> Result<(), Failure> {
    if json {
        return print_json(value);
    }
    let mut out = terminal::out();
    write(value, &mut out)?;
    Ok(out.flush()?)
}

/// Prints a value as one line of JSON on standard output.
pub(crate) fn print_json(value: &impl serde::Serialize) -> Result<(), Failure> {
    let json = serde_json::to_string(value).map_err(std::io::Error::from)?;
    writeln!(terminal::raw_out(), "{}", escape_json(&json))?;
    Ok(())
}
