//! Very many schemas: in real time, beside as many threads that only sleep, and in lockstep, faster than real
//! time.

use std::fmt::Write as _;
use std::time::{Duration, Instant};

use anyhow::{Context as _, Result};
use jde_core::State;
use jde_host::{Lockstep, Options};
use jde_measure::figure::{Figure, Goal, Line};
use jde_measure::grid::Grid;
use jde_measure::pairs::Rounds;

use super::jitter::{application, late_by, lateness};
use crate::schemas::{self, ROLES};
use crate::scope::Scope;
use crate::{bare, live, loaded};

/// The number of schemas in real time.
const MANY: usize = 1000;
/// The number of nested groups.
const DEEP: usize = 99;
const MS: u64 = 1_000_000;
/// The period of all schemas in lockstep, ns.
const PERIOD: u64 = 50 * MS;

pub(crate) fn thousand(scope: &Scope) -> Result<Vec<Line>> {
    let time = Duration::from_secs(scope.either(1, 5));
    // The periods range from 10 to 75 ms.
    let periods: Vec<Duration> = (0..MANY)
        .map(|number| Duration::from_micros(10_000 + 65_000 * number as u64 / MANY as u64))
        .collect();
    let grids = Grid::all(&periods);
    let texts = [application(&periods, "pool"), application(&periods, "threads")];
    let mut spent = [const { Vec::new() }; 3];
    let mut late = [const { Vec::new() }; 3];
    let mut missed = [0; 3];
    for _ in 0..scope.either(1, 5) {
        for (index, text) in texts.iter().enumerate() {
            let run = live::run(text, time)?;
            spent[index].push(percent(run.processor, time));
            missed[index] += run.missed;
            late[index].push(lateness(&run, &grids)?);
        }
        let slept = bare::sleepers(&grids, time);
        let missed_deadlines = |(late, period): (&Vec<u64>, &Duration)| {
            late.iter()
                .filter(|late| u128::from(**late) >= period.as_nanos())
                .count() as u64
        };
        missed[2] += slept.late.iter().zip(&periods).map(missed_deadlines).sum::<u64>();
        spent[2].push(percent(slept.processor, time));
        late[2].push(slept.late.iter().flatten().map(|late| *late as f64).collect());
    }
    let spent = spent.map(Rounds::of);
    let mut lines = Vec::new();
    for (index, executor) in ["pool", "threads"].into_iter().enumerate() {
        let line = Line::compared(
            format!("{MANY} schemas of 10 to 75 ms, executor \"{executor}\""),
            Figure::Processor(spent[index].median()),
            "as many threads in clock_nanosleep",
            Figure::Processor(spent[2].median()),
            Goal::AtMost(1.2),
        );
        lines.push(line.paired(spent[index].ratio_to(&spent[2])));
        lines.push(Line::compared(
            format!("their missed periods, executor \"{executor}\""),
            Figure::Count(missed[index] as f64),
            "as many threads in clock_nanosleep",
            Figure::Count(missed[2] as f64),
            Goal::Below(Figure::Count(0.0)),
        ));
        let what = format!("they are late by, executor \"{executor}\"");
        lines.extend(late_by(&what, &late[index], &late[2], Goal::AtMost(1.2)));
    }
    Ok(lines)
}

pub(crate) fn ten_thousand(scope: &Scope) -> Result<Vec<Line>> {
    let text = nested_application();
    let plugins = schemas::plugins()?;
    let before = resident()?;
    let application = loaded::application(&text, &plugins)?;
    let mut lockstep = Lockstep::start(application, &plugins, Options::default())?;
    // Each level wakes the next within a period.
    let mut now = PERIOD * (DEEP as u64 + 2);
    lockstep.run_until(now);
    let awake = lockstep
        .handle()
        .snapshot()
        .schemas
        .iter()
        .filter(|schema| schema.state != State::Slept)
        .count();
    let memory = resident()? - before;
    let mut speeds = Vec::new();
    for _ in 0..scope.either(3, 15) {
        let (start, time) = (Instant::now(), 20 * PERIOD);
        now += time;
        lockstep.run_until(now);
        speeds.push(time as f64 / start.elapsed().as_nanos() as f64);
    }
    Ok(vec![
        Line::new(
            format!(
                "{awake} awake schemas of 20 Hz, {DEEP} groups deep, {} wide",
                ROLES.len()
            ),
            Figure::Speed(Rounds::of(speeds).median()),
            Goal::Least(Figure::Speed(1.0)),
        ),
        Line::new(
            "memory of each of them, everything included",
            Figure::Bytes(memory as f64 / awake as f64),
            Goal::ReportOnly,
        ),
    ])
}

/// An application of nested groups: the first child of each group is the father of the next group.
fn nested_application() -> String {
    let mut text = String::from("roots = [\"f0\"]\n");
    for level in 0..DEEP {
        let children = ROLES.iter().enumerate().map(|(index, role)| {
            if index == 0 && level + 1 < DEEP {
                format!("{role} = \"f{}\"", level + 1)
            } else {
                format!("{role} = \"l{level}-{index}\"")
            }
        });
        let children: Vec<String> = children.collect();
        let _ = writeln!(
            text,
            "[schemas.f{level}]\ntype = \"pace/parent\"\nchildren = {{ {} }}",
            children.join(", ")
        );
        for index in usize::from(level + 1 < DEEP)..ROLES.len() {
            let _ = writeln!(text, "[schemas.l{level}-{index}]\ntype = \"pace/leaf\"");
        }
    }
    text
}

fn percent(spent: u64, time: Duration) -> f64 {
    100.0 * spent as f64 / time.as_nanos() as f64
}

/// Returns the resident memory of this process, bytes.
fn resident() -> Result<u64> {
    let text = std::fs::read_to_string("/proc/self/statm")?;
    let pages = text.split(' ').nth(1).context("statm has no second number")?;
    Ok(pages.parse::<u64>()? * rustix::param::page_size() as u64)
}
