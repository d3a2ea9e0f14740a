//! Experiments: how many times faster than real time the drives of safe navigation run, on one core and on two, beside a loop
//! over a robot simulator in Python.

use std::fs;
use std::path::Path;
use std::process::Command;
use std::time::Instant;

use anyhow::{Context as _, Result, ensure};
use jde_measure::figure::{Figure, Goal, Line};
use jde_measure::pairs::Rounds;
use serde::{Deserialize, Serialize};

use crate::product;
use crate::scope::Scope;

/// The seconds of a drive of safe navigation that the Python loop simulates: enough for a steady rate.
const LOOP_SECONDS: f64 = 60.0;

pub(crate) fn run(scope: &Scope) -> Result<Vec<Line>> {
    let folder = tempfile::tempdir()?;
    let mut speeds = Vec::new();
    let mut ratios = Vec::new();
    // Alternately, because the machine's speed drifts.
    for _ in 0..scope.either(1, 3) {
        let one = speed(scope, folder.path(), 1)?;
        let two = speed(scope, folder.path(), 2)?;
        speeds.push(one);
        ratios.push(100.0 * two / one);
    }
    let one = Figure::Speed(Rounds::of(speeds).median());
    let mut lines = vec![
        Line::new(
            "a hundred drives of safe navigation, judged, one job",
            one,
            Goal::Least(Figure::Speed(1500.0)),
        ),
        Line::new(
            "the same with two jobs, as a share of one job's speed",
            Figure::Share(Rounds::of(ratios).median()),
            Goal::Least(Figure::Share(190.0)),
        ),
    ];
    if let Some(python) = &scope.python {
        lines.push(Line::compared(
            "one core, a laser of 180 beams at 20 Hz",
            one,
            "ir-sim, a loop in Python",
            Figure::Speed(ir_sim(scope, python)?),
            Goal::ReportOnly,
        ));
    }
    Ok(lines)
}

/// A line of `results.jsonl`.
#[derive(Deserialize)]
struct Drive {
    seconds: f64,
    outcome: String,
}

/// Returns seconds of the application for each second of the machine, with the start of all processes.
fn speed(scope: &Scope, folder: &Path, jobs: usize) -> Result<f64> {
    let out = folder.join("results");
    let mut command = product::jde(scope, folder);
    command
        .arg("experiment")
        .arg(scope.root.join("experiments/safe-navigation.toml"))
        .args(["--replace", "--jobs", &jobs.to_string(), "--out"])
        .arg(&out);
    let started = Instant::now();
    product::read(&mut command)?;
    let wall = started.elapsed().as_secs_f64();
    let text = fs::read_to_string(out.join("results.jsonl"))?;
    let drives = text.lines().map(serde_json::from_str::<Drive>);
    let drives = drives.collect::<Result<Vec<_>, _>>().context("the results")?;
    ensure!(
        drives.iter().all(|drive| drive.outcome == "passed"),
        "a drive did not pass"
    );
    Ok(drives.iter().map(|drive| drive.seconds).sum::<f64>() / wall)
}

/// The input of the loop in Python.
#[derive(Serialize)]
struct Request {
    seconds: f64,
    step: f64,
    beams: usize,
    range: f64,
}

/// The output of the loop in Python.
#[derive(Deserialize)]
struct Response {
    speed: f64,
}

fn ir_sim(scope: &Scope, python: &Path) -> Result<f64> {
    let request = Request {
        seconds: LOOP_SECONDS,
        step: 0.05,
        beams: 180,
        range: 8.0,
    };
    let mut command = Command::new(python);
    command.arg(scope.root.join("benches/peers/ir_sim_loop.py"));
    let output = product::run_with_input(&mut command, &serde_json::to_string(&request)?)?;
    Ok(serde_json::from_str::<Response>(&output)?.speed)
}
