//! The delays of schemas' periods, beside as many threads that only sleep until their deadlines.

use std::fmt::Write as _;
use std::time::Duration;

use anyhow::{Result, ensure};
use jde_measure::figure::{Figure, Goal, Line};
use jde_measure::grid::Grid;
use jde_measure::pairs::{Rounds, quantile};

use crate::scope::Scope;
use crate::{bare, live};

/// The executors that run in real time.
const EXECUTORS: [&str; 2] = ["threads", "pool"];

pub(crate) fn run(scope: &Scope) -> Result<Vec<Line>> {
    let mut lines = Vec::new();
    for (period, seconds) in [(Duration::from_millis(1), 2), (Duration::from_millis(75), 4)] {
        for schemas in [10, 100] {
            let time = Duration::from_secs(scope.either(1, seconds));
            lines.extend(compare(scope, schemas, period, time)?);
        }
    }
    Ok(lines)
}

fn compare(scope: &Scope, schemas: usize, period: Duration, time: Duration) -> Result<Vec<Line>> {
    let periods = vec![period; schemas];
    let grids = Grid::all(&periods);
    let texts = EXECUTORS.map(|executor| application(&periods, executor));
    let (mut ours, mut bare) = (EXECUTORS.map(|_| Vec::new()), Vec::new());
    for _ in 0..scope.either(1, 9) {
        for (text, ours) in texts.iter().zip(&mut ours) {
            let run = live::run(text, time)?;
            ours.push(lateness(&run, &grids)?);
        }
        let slept = bare::sleepers(&grids, time);
        let late = slept.late.iter().flatten();
        bare.push(late.map(|late| *late as f64).collect());
    }
    let mut lines = Vec::new();
    for (executor, ours) in EXECUTORS.iter().zip(&ours) {
        let what = format!(
            "{schemas} schemas of {} ms late by, \"{executor}\"",
            period.as_millis()
        );
        lines.extend(late_by(&what, ours, &bare, Goal::AtMost(1.2)));
    }
    Ok(lines)
}

/// Compares delays of turns with delays of threads' sleeps. Each list holds one run.
pub(crate) fn late_by(what: &str, ours: &[Vec<f64>], bare: &[Vec<f64>], goal: Goal) -> [Line; 2] {
    let of =
        |runs: &[Vec<f64>], share| Rounds::of(runs.iter().map(|run| quantile(run.clone(), share)).collect());
    [("median", 0.5), ("p99", 0.99)].map(|(name, share)| {
        let (ours, bare) = (of(ours, share), of(bare, share));
        Line::beside(
            format!("{what}, {name}"),
            Figure::Time(ours.median()),
            "threads in clock_nanosleep",
            Figure::Time(bare.median()),
            goal,
        )
        .paired(ours.by(&bare))
    })
}

/// An application of schemas that are all roots of one group.
pub(crate) fn application(periods: &[Duration], executor: &str) -> String {
    let names: Vec<String> = (0..periods.len())
        .map(|number| format!("\"s{number}\""))
        .collect();
    let mut text = format!("roots = [{}]\nexecutor = \"{executor}\"\n", names.join(", "));
    for (number, period) in periods.iter().enumerate() {
        let _ = writeln!(
            text,
            "[schemas.s{number}]\ntype = \"pace/beat\"\nperiod = \"{}us\"",
            period.as_micros()
        );
    }
    text
}

/// Returns the delays of turns after their deadlines, ns, without those of the start.
pub(crate) fn lateness(run: &live::Run, grids: &[Grid]) -> Result<Vec<f64>> {
    let from = run.woken + live::START.as_nanos() as u64;
    let mut all = Vec::new();
    for notes in &run.notes {
        if let Some((number, times)) = notes.split_first() {
            let late = grids[*number as usize].late(run.woken, times, from);
            all.extend(late.into_iter().map(|late| late as f64));
        }
    }
    ensure!(!all.is_empty(), "no schema woke");
    Ok(all)
}
