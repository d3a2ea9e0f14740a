//! One drive of an experiment, run here: with what led to its result, and a recording.

use std::io::{self, Write};
use std::time::Instant;

use jde_experiment::Experiment;
use jde_experiment::applications::Applications;
use jde_experiment::drive::PreparedDrive;
use jde_experiment::result::{DriveResult, Outcome};
use jde_host::{Options, StartError};
use jde_session::log::{Filter, Log};
use jde_session::run::{Extension, RunContext};
use jde_session::summary::print_recording;
use jde_terminal::escape::escape_json;
use jde_terminal::{self as terminal, BAD, FAINT, GOOD, TITLE};

use crate::extensions::RecordOptions;
use crate::failure::Failure;

/// Runs a drive, and prints its result.
///
/// # Errors
/// It could not start, or did not pass.
pub(super) fn run(
    experiment: &Experiment,
    (drive, seed): (usize, Option<u64>),
    applications: &mut Applications,
    record: Option<RecordOptions>,
    filter: Option<Filter>,
    json: bool,
) -> Result<(), Failure> {
    if drive >= experiment.drives() {
        return Err(Failure::usage(
            format!("there is no drive {drive}"),
            format!("the experiment has {} drives, from 0", experiment.drives()),
        ));
    }
    let log = Some(Log::start(filter.unwrap_or_default()));
    let prepared = PreparedDrive::new(experiment, drive, seed, applications).map_err(Failure::faults)?;
    let context = RunContext {
        application: &prepared.application,
        lockstep: true,
        speed: 1.0,
    };
    let recording = record
        .map(|record| RecordOptions { log, ..record }.prepare(&context))
        .transpose()
        .map_err(StartError::HookFailed)?
        .flatten();
    let mut options = Options {
        isolation_program: Some(jde_session::child::program()),
        ..Options::default()
    };
    if let Some(recording) = &recording {
        options.observers.push(recording.observer());
        options.on_turn = recording.on_turn();
        options.start_hook = Some(recording.before_start(&prepared.plugins));
    }
    let started = Instant::now();
    let result = prepared.run(experiment, options)?;
    let wall = started.elapsed().as_secs_f64();
    let recorded = recording.and_then(|recording| recording.finish());
    let mut output = terminal::text_out(json);
    print(&mut output, experiment, &result, wall)?;
    if let Some(recorded) = &recorded {
        print_recording(recorded, &mut output)?;
    }
    output.flush()?;
    if json {
        let line = result.to_line(&experiment.columns);
        writeln!(terminal::raw_out(), "{}", escape_json(&line))?;
    }
    match result.outcome {
        Outcome::Passed => Ok(()),
        Outcome::Failed | Outcome::Crashed | Outcome::Hung | Outcome::Broken => Err(Failure::mission()),
    }
}

fn print(output: &mut dyn Write, experiment: &Experiment, result: &DriveResult, wall: f64) -> io::Result<()> {
    if let Some(failure) = &result.failure {
        for selection in &failure.selections {
            writeln!(output, "{FAINT}{selection}{FAINT:#}")?;
        }
    }
    let style = if result.outcome == Outcome::Passed {
        GOOD
    } else {
        BAD
    };
    write!(
        output,
        "{TITLE}{} drive {}{TITLE:#}: {style}{}{style:#} after {:.1} s",
        experiment.name,
        result.drive,
        result.outcome.word(),
        result.seconds
    )?;
    writeln!(
        output,
        "{FAINT}, {:.0} times as fast as real time{FAINT:#}",
        result.seconds / wall
    )?;
    for (name, value) in experiment.columns.axes.iter().zip(&result.axes) {
        writeln!(output, "  {name} = {value}")?;
    }
    for (name, holds) in experiment.columns.properties.iter().zip(&result.properties) {
        let (style, word) = match holds {
            Some(true) => (GOOD, "holds"),
            Some(false) => (BAD, "FAILS"),
            None => (FAINT, "not judged"),
        };
        writeln!(output, "  {style}{word:<10}{style:#}  {name}")?;
    }
    for (measure, value) in experiment.columns.measures.iter().zip(&result.measures) {
        let value = value.map_or_else(
            || String::from("no value"),
            |value| format!("{value:.4} {}", measure.unit),
        );
        writeln!(output, "  {value:<10}  {}", measure.name)?;
    }
    if !result.why.is_empty() {
        writeln!(output, "{BAD}{}{BAD:#}", result.why)?;
    }
    Ok(())
}
