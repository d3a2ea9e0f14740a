//! How late the periods of schemas begin, beside as many threads that only sleep until their deadlines.

use std::fmt::Write as _;
use std::time::Duration;

use anyhow::{Result, ensure};

use crate::figure::{Figure, Goal, Line};
use crate::grid::Grid;
use crate::pairs::{Rounds, quantile};
use crate::scope::Scope;
use crate::{bare, live};

/// Of each instance these are left out: its name's number, the call as it awakes, and the one as it becomes the winner.
const FIRST: usize = 4;
/// Both ways in real time.
pub(crate) const EXECUTORS: [&str; 2] = ["threads", "pool"];

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
            let notes = run.notes.iter();
            let late: Vec<f64> = notes.flat_map(|woke| lateness(woke, run.woken, &grids)).collect();
            ensure!(!late.is_empty(), "nobody woke");
            ours.push(late);
        }
        let slept = bare::sleepers(&grids, time);
        let late = slept.late.iter().flat_map(|late| late.iter().skip(FIRST));
        bare.push(late.map(|late| *late as f64).collect());
    }
    let of = |runs: &[Vec<f64>], share| {
        Rounds::of(runs.iter().map(|run| quantile(run.clone(), share)).collect())
    };
    let mut lines = Vec::new();
    for (executor, ours) in EXECUTORS.iter().zip(&ours) {
        for (what, share) in [("median", 0.5), ("p99", 0.99)] {
            let (ours, bare) = (of(ours, share), of(&bare, share));
            let line = Line::beside(
                format!("{schemas} schemas of {} ms late by, \"{executor}\", {what}", period.as_millis()),
                Figure::Time(ours.median()),
                "threads in clock_nanosleep",
                Figure::Time(bare.median()),
                Goal::AtMost(1.2),
            );
            lines.push(line.paired(ours.by(&bare)));
        }
    }
    Ok(lines)
}

/// An application of schemas that all compete at the top.
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

/// By how much wake-ups came after their deadlines, ns.
fn lateness(woke: &[u64], woken: u64, grids: &[Grid]) -> impl Iterator<Item = f64> {
    let number = woke.first().copied().unwrap_or_default();
    let grid = grids[number as usize];
    woke.iter()
        .skip(FIRST)
        .map(move |at| grid.late(woken, *at) as f64)
}
