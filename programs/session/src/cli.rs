//! What all command lines of jde share: their common options, the output of values and of the result of a run, and the
//! exit status.

use std::io::{self, Write};
use std::process::ExitCode;

use jde_files::is_control;
use jde_terminal::escape::escape_json;
use jde_terminal::{self as terminal, Color, own_styles};

use crate::failure::Failure;
use crate::load::LoadedApplication;
use crate::log::{Filter, Log};
use crate::run::Finished;
use crate::summary::{self, RunSummary};

/// Options common to all verbs.
#[derive(clap::Args)]
pub struct Common {
    /// When to use colours.
    #[arg(long, global = true, value_enum, default_value_t, value_name = "WHEN")]
    pub color: Color,
    /// The part of the log to show on standard error: LEVEL, SCHEMA=LEVEL, or state=LEVEL for changes of
    /// state; separate several with commas. Levels: off, error, warn (the default), info, debug, trace.
    #[arg(long, global = true, value_name = "FILTER", value_parser = clap::value_parser!(Filter))]
    pub log: Option<Filter>,
}

/// Returns the exit status after all printed output has been written, or its reader has stopped reading. `report` prints a
/// failure and returns its status.
pub fn exit_status<E: From<io::Error>>(
    result: Result<(), E>,
    report: impl FnOnce(&E) -> ExitCode,
) -> ExitCode {
    let drained = terminal::drain();
    let status = match result.and(drained.map_err(E::from)) {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => report(&failure),
    };
    // Flushes the error report. A failure of this flush cannot be reported anywhere.
    let _ = terminal::drain();
    status
}

/// Prints a clap message: help and version to standard output with status 0, wrong use to standard error with
/// status 2.
#[must_use]
pub fn report_usage_error(error: &clap::Error) -> ExitCode {
    print_help(error);
    let _ = terminal::drain();
    ExitCode::from(u8::from(error.use_stderr()) * 2)
}

/// Prints clap's own output: help, the version, or the description of wrong use.
pub fn print_help(error: &clap::Error) {
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
///
/// # Errors
/// The filter names a schema that does not exist.
pub fn start_log(filter: Option<Filter>, loaded: &LoadedApplication) -> Result<Log, Failure> {
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
///
/// # Errors
/// The run did not fulfil its purpose, as `fulfilled` judges it, or its results are not complete.
pub fn conclude(
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
    if summary.has_unexpected_fault {
        return Err(Failure::Fault);
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
///
/// # Errors
/// Standard output could not be written.
pub fn print_value<T: serde::Serialize>(
    json: bool,
    value: &T,
    write: impl FnOnce(&T, &mut dyn Write) -> io::Result<()>,
) -> io::Result<()> {
    if json {
        return print_json(value);
    }
    let mut out = terminal::out();
    write(value, &mut out)?;
    out.flush()
}

/// Prints a value as one line of JSON on standard output.
///
/// # Errors
/// Standard output could not be written.
pub fn print_json(value: &impl serde::Serialize) -> io::Result<()> {
    let json = serde_json::to_string(value).map_err(io::Error::from)?;
    writeln!(terminal::raw_out(), "{}", escape_json(&json))
}
