//! The cost of a recording of the whole demonstration: processor time, and delays of the robot's periods.

use std::fs;
use std::path::Path;
use std::process::Command;

use anyhow::{Context as _, Result, ensure};
use jde_measure::figure::{Figure, Goal, Line};
use jde_measure::grid::after_the_earliest;
use jde_measure::pairs::{Rounds, quantile};

use crate::product;
use crate::scope::Scope;

/// The demonstration, and its list of roots as the file has it.
const APPLICATION: &str = "apps/safe-navigation.toml";
const ROOTS: &str = "[\"teleop\", \"example\"]";

/// The result of a run.
struct Run {
    /// Processor time, in percent of one processor.
    processor: f64,
    /// How much later than the earliest of them the periods of an additional schema began, ns.
    late: Vec<f64>,
}

pub(crate) fn run(scope: &Scope) -> Result<Vec<Line>> {
    let folder = tempfile::tempdir()?;
    let application = folder.path().join("recorded.toml");
    let text = fs::read_to_string(scope.root.join(APPLICATION))?;
    ensure!(text.contains(ROOTS), "{APPLICATION} has other roots");
    // Paths in the file are relative to its folder.
    let text = text.replace("\"../", &format!("\"{}/", scope.root.display()));
    // The mission is removed, since the run ends before it is done.
    let text = text.replace("mission = ", "# mission = ");
    // `clockwork` only records when its periods begin; it is never ready.
    let text = text.replace(ROOTS, "[\"teleop\", \"example\", \"clockwork\"]");
    fs::write(
        &application,
        text + "\n[schemas.clockwork]\ntype = \"bench-000/clockwork\"\n",
    )?;
    let (mut with, mut without) = (Vec::new(), Vec::new());
    for _ in 0..scope.either(1, 7) {
        with.push(drive(scope, folder.path(), &application, true)?);
        without.push(drive(scope, folder.path(), &application, false)?);
    }
    let more: Vec<f64> = with
        .iter()
        .zip(&without)
        .map(|(a, b)| a.processor - b.processor)
        .collect();
    let line = |what: &str, share: f64| {
        let of =
            |runs: &[Run]| Rounds::of(runs.iter().map(|run| quantile(run.late.clone(), share)).collect());
        let (ours, theirs) = (of(&with), of(&without));
        Line::compared(
            format!("periods of 10 ms while it is recorded late by, {what}"),
            Figure::Time(ours.median()),
            "the same, not recorded",
            Figure::Time(theirs.median()),
            Goal::AtMost(1.2),
        )
        .paired(ours.ratio_to(&theirs))
    };
    Ok(vec![
        Line::new(
            "recording all of the demonstration, more than without",
            Figure::Processor(Rounds::of(more).median()),
            Goal::Below(Figure::Processor(3.0)),
        ),
        line("median", 0.5),
        line("p99", 0.99),
    ])
}

/// The period of `clockwork`, ns.
const PERIOD: u64 = 10_000_000;

/// Runs the demonstration for some seconds in real time.
fn drive(scope: &Scope, folder: &Path, application: &Path, record: bool) -> Result<Run> {
    let seconds = scope.either(3, 10);
    let notes = folder.join("notes");
    let mut command: Command = product::jde(scope, folder);
    command
        .args(["run", "--plain", "--for", &format!("{seconds}s")])
        .arg(application);
    command.env("JDE_BENCH_NOTES", &notes);
    if record {
        let file = folder.join("recorded.mcap");
        // A recording does not overwrite an existing file.
        let _ = fs::remove_file(&file);
        command.arg("--record").arg(file);
    }
    let before = product::children_processor_time()?;
    product::read(&mut command)?;
    let processor = product::children_processor_time()? - before;
    let times = fs::read_to_string(&notes).context("no times were recorded")?;
    let times = times
        .lines()
        .skip(1)
        .map(|line| Ok(line.parse()?))
        .collect::<Result<Vec<u64>>>()?;
    ensure!(times.len() > 1, "only {} periods were recorded", times.len());
    Ok(Run {
        processor: 100.0 * processor / f64::from(seconds),
        late: after_the_earliest(&times, PERIOD),
    })
}
