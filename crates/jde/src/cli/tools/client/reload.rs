//! `jde reload`: makes new builds take over in a running application.

use std::io::{self, Write};

use clap::Args;
use clap_complete::ArgValueCompleter;
use jde_core::Nanos;
use jde_link::message::{Action, Request};
use jde_records::reload::{ReloadOutcome, ReloadReport, Replacement};

use super::{Context, Target};
use crate::cli::print_json;
use crate::cli::tools::quantity;
use crate::complete;
use crate::failure::Failure;
use crate::remote::name::split_application;
use crate::terminal::{self, BAD, FAINT, GOOD, TextWriter, WARN};

/// Replace the code of a schema while it runs: the current build in its plugin's file takes over between two
/// iterations.
///
/// The schema keeps its state in the hierarchy, its authority and its variables. It also keeps its memory if
/// the old build saves it. The build is checked first: if it does not fit the application, nothing changes
/// and all reasons are listed. If it fails in its first seconds, the previous build takes over again.
///
/// The exit status is 0 if every schema runs what is in the file, 1 if not.
#[derive(Args)]
#[command(after_help = "Examples:
  cargo build && jde reload vff
  jde reload ball                   a plugin: all its schemas
  jde reload robot2:vff --probation 10s
  jde reload vff --fresh --json")]
pub(crate) struct Reload {
    /// The schema, or a plugin for all its schemas; also APP:NAME.
    #[arg(value_name = "NAME", add = ArgValueCompleter::new(complete::schemas_and_plugins))]
    name: String,
    #[command(flatten)]
    target: Target,
    /// How long the previous build is kept for a return to it; 0s for not at all.
    #[arg(long, value_name = "TIME", value_parser = quantity::time_or_zero, default_value = "3s")]
    probation: Nanos,
    /// Start without the memory of the previous build.
    #[arg(long)]
    fresh: bool,
    /// Print one line of JSON.
    #[arg(long)]
    json: bool,
}

impl Reload {
    pub(crate) fn run(self, context: &Context) -> Result<(), Failure> {
        let (named, name) = split_application(&self.name);
        let remote = context.remote(&self.target, named)?;
        let request = Request {
            by: jde_link::operator(),
            action: Action::Reload {
                schema: name.to_owned(),
                probation_s: Some(self.probation as f64 / 1e9),
                fresh: self.fresh,
            },
            lease_ms: None,
        };
        let reloaded = match remote.reload(&request) {
            Ok(reloaded) => reloaded,
            Err(jde_link::Error::Refused { text, nearest: None }) => return Err(Failure::NotReloaded(text)),
            Err(error) => return Err(error.into()),
        };
        if self.json {
            print_json(&reloaded)?;
        } else {
            let mut out = terminal::out();
            write_results(&reloaded, &mut out)?;
            out.flush()?;
        }
        let undone: Vec<_> = reloaded
            .schemas
            .iter()
            .filter(|(_, became)| matches!(became, ReloadOutcome::Undone(_) | ReloadOutcome::Waiting))
            .map(|(schema, _)| schema.as_str())
            .collect();
        if reloaded.is_done() {
            Ok(())
        } else {
            Err(Failure::NotReloaded(format!(
                "not every schema runs the new build: {}",
                undone.join(", ")
            )))
        }
    }
}

/// Prints the result of each schema.
fn write_results(reloaded: &ReloadReport, words: &mut TextWriter) -> io::Result<()> {
    for (schema, became) in &reloaded.schemas {
        match became {
            ReloadOutcome::Reloaded(takeover) => write_takeover(schema, takeover, words)?,
            ReloadOutcome::Unchanged => writeln!(
                words,
                "{schema} runs what is in {} already",
                reloaded.file.display()
            )?,
            ReloadOutcome::Restarted => writeln!(
                words,
                "{schema} runs what is in {} already; it had faulted and tries again",
                reloaded.file.display()
            )?,
            ReloadOutcome::Undone(reason) => {
                writeln!(words, "{BAD}{schema} goes on as before{BAD:#}: {reason}")?
            }
            ReloadOutcome::Waiting => writeln!(
                words,
                "{WARN}{schema} is inside a call{WARN:#}; the new build takes over when that returns"
            )?,
        }
    }
    let memory = &reloaded.memory;
    if memory.builds > 0 {
        let builds = if memory.builds == 1 { "build" } else { "builds" };
        writeln!(
            words,
            "{FAINT}{} {builds} of {} in memory beside the first, {:.1} MB{FAINT:#}",
            memory.builds,
            jde_loader::MAX_BUILDS,
            memory.bytes as f64 / 1e6
        )?;
    }
    Ok(())
}

fn write_takeover(schema: &str, takeover: &Replacement, words: &mut TextWriter) -> io::Result<()> {
    let carried = takeover
        .carried
        .map_or_else(|| "it begins anew".to_owned(), |carried| carried.to_string());
    let took = takeover.took as f64 / 1e6;
    let gap = match takeover.gap {
        Some(gap) => format!(
            "gap {:.1} ms, of which the exchange took {took:.1} ms",
            gap as f64 / 1e6
        ),
        None => format!("it sleeps; the exchange took {took:.1} ms"),
    };
    writeln!(words, "{GOOD}{schema} runs {}{GOOD:#}", takeover.build)?;
    writeln!(words, "  {carried}; {gap}")?;
    for note in &takeover.notes {
        writeln!(words, "  {WARN}note{WARN:#}: {note}")?;
    }
    if takeover.probation > 0 {
        writeln!(
            words,
            "  {FAINT}on trial for {} s: until then a fault goes back to the build before{FAINT:#}",
            takeover.probation as f64 / 1e9
        )?;
    }
    Ok(())
}
