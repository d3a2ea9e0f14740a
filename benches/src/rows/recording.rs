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
        Line::beside(
            format!("periods of 10 ms while it is recorded late by, {what}"),
            Figure::Time(ours.median()),
            "the same, not recorded",
            Figure::Time(theirs.median()),
            Goal::AtMost(1.2),
        )
        .paired(ours.by(&theirs))
    };
    Ok(vec![
        Line::alone(
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
    let before = children()?;
    product::read(&mut command)?;
    let processor = children()? - before;
    let began = fs::read_to_string(&notes).context("the schema wrote no notes")?;
    let began = began
        .lines()
        .skip(1)
        .map(|line| Ok(line.parse()?))
        .collect::<Result<Vec<u64>>>()?;
    ensure!(began.len() > 1, "the schema recorded {} periods", began.len());
    Ok(Run {
        processor: 100.0 * processor / f64::from(seconds),
        late: after_the_earliest(&began, PERIOD),
    })
}

/// Returns the processor time of all child processes that have ended, s.
fn children() -> Result<f64> {
    let text = fs::read_to_string("/proc/self/stat")?;
    // The name may contain blanks; the rest does not.
    let (_, rest) = text.rsplit_once(')').context("stat has no name")?;
    let fields: Vec<&str> = rest.split_whitespace().collect();
    let ticks: u64 = fields[13].parse::<u64>()? + fields[14].parse::<u64>()?;
    Ok(ticks as f64 / rustix::param::clock_ticks_per_second() as f64)
}
