//! `jde reload`: makes new builds take over in a running application.

use std::io::{self, Write};
use std::time::Duration;

use clap::Args;
use clap_complete::ArgValueCompleter;
use jde_core::Nanos;
use jde_link::message::Action;
use jde_records::reload::{ReloadOutcome, ReloadReport};
use jde_session::cli::print_value;
use jde_terminal::{BAD, GOOD, WARN};

use super::apps::format_span;
use super::operate::check_known;
use super::{Context, Target};
use crate::complete;
use crate::failure::{Failure, display_path};
use crate::quantity;
use crate::remote::name::split_application;
use crate::remote::request;

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
    /// How long the previous build is kept in case the new one fails; 0s keeps none.
    #[arg(long, value_name = "TIME", allow_hyphen_values = true, value_parser = quantity::time_offset,
          default_value = "3s")]
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
        let request = request(Action::Reload {
            schema: name.to_owned(),
            probation_s: Some(self.probation as f64 / 1e9),
            fresh: self.fresh,
        });
        let reloaded = match remote.reload(&request) {
            Ok(reloaded) => reloaded,
            Err(jde_link::Error::Refused { text, nearest: None }) => {
                check_known(&remote, "schema or plugin", name)?;
                return Err(Failure::NotReloaded(text));
            }
            Err(error) => return Err(error.into()),
        };
        print_value(self.json, &reloaded, write_results)?;
        let undone: Vec<_> = reloaded
            .schemas
            .iter()
            .filter(|(_, outcome)| matches!(outcome, ReloadOutcome::Undone(_) | ReloadOutcome::Waiting))
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

/// Prints one line for the plugin, and a line for each schema that needs attention.
fn write_results(reloaded: &ReloadReport, output: &mut dyn Write) -> io::Result<()> {
    let file = display_path(&reloaded.file);
    let age = reloaded.age.map_or_else(String::new, |age| {
        format!(", built {} ago", format_span(Duration::from_nanos(age)))
    });
    let names_of = |is: fn(&ReloadOutcome) -> bool| {
        let schemas = reloaded.schemas.iter().filter(|(_, outcome)| is(outcome));
        let names: Vec<_> = schemas.map(|(schema, _)| schema.as_str()).collect();
        (!names.is_empty()).then(|| names.join(", "))
    };
    let results = [
        names_of(|outcome| matches!(outcome, ReloadOutcome::Reloaded(_)))
            .map(|names| format!("{GOOD}reloaded {names}{GOOD:#} {}", describe_takeovers(reloaded))),
        names_of(|outcome| matches!(outcome, ReloadOutcome::Unchanged))
            .map(|names| format!("{names} unchanged")),
        names_of(|outcome| matches!(outcome, ReloadOutcome::Restarted))
            .map(|names| format!("{names} unchanged, restarted after a fault")),
        names_of(|outcome| matches!(outcome, ReloadOutcome::Undone(_)))
            .map(|names| format!("{BAD}{names} not reloaded{BAD:#}")),
        names_of(|outcome| matches!(outcome, ReloadOutcome::Waiting))
            .map(|names| format!("{WARN}{names} inside a call{WARN:#}, to be reloaded when it returns")),
    ];
    let results: Vec<_> = results.into_iter().flatten().collect();
    writeln!(output, "{file}{age}: {}", results.join("; "))?;
    for (schema, outcome) in &reloaded.schemas {
        match outcome {
            ReloadOutcome::Undone(reason) => writeln!(output, "  {BAD}{schema}{BAD:#}: {reason}")?,
            ReloadOutcome::Reloaded(takeover) => {
                for note in &takeover.notes {
                    writeln!(output, "  {WARN}{schema}{WARN:#}: {note}")?;
                }
            }
            ReloadOutcome::Unchanged | ReloadOutcome::Restarted | ReloadOutcome::Waiting => {}
        }
    }
    Ok(())
}

/// Describes how the new build took over: "to 0.2.0, with 37 bytes of memory, gap 16.3 ms, on trial for 3 s".
fn describe_takeovers(reloaded: &ReloadReport) -> String {
    let takeovers = reloaded.schemas.iter().filter_map(|(_, outcome)| match outcome {
        ReloadOutcome::Reloaded(takeover) => Some(takeover),
        _ => None,
    });
    let version = takeovers.clone().map(|takeover| &takeover.build.version).next();
    let mut parts = vec![format!("to {}", version.map_or("the new build", String::as_str))];
    let carried = takeovers.clone().filter_map(|takeover| takeover.carried);
    parts.push(
        match carried
            .map(|memory| memory.bytes)
            .reduce(|sum, bytes| sum + bytes)
        {
            Some(bytes) => format!("with {bytes} bytes of memory"),
            None => "with fresh memory".to_owned(),
        },
    );
    if let Some(gap) = takeovers.clone().filter_map(|takeover| takeover.gap).max() {
        parts.push(format!("gap {:.1} ms", gap as f64 / 1e6));
    }
    if let Some(trial) = takeovers
        .map(|takeover| takeover.probation)
        .max()
        .filter(|trial| *trial > 0)
    {
        parts.push(format!("on trial for {} s", trial as f64 / 1e9));
    }
    parts.join(", ")
}
