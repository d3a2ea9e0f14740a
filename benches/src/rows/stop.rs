//! The time from the scan that shows an obstacle to the driver that stands, by a guard and by `stop`, with idle
//! processors and beside as many threads that compute.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use anyhow::{Result, bail};
use jde_measure::figure::{Figure, Goal, Line};

use crate::scope::Scope;
use crate::{live, loaded};

const GUARDED: &str = r#"
    roots = ["cruise"]
    root = { guard = "guard", retry = "5ms" }
    [schemas.base]
    type = "pace/base"
    [schemas.guard]
    type = "guard/footprint"
    imports = { laser = "base.laser", pose = "base.pose" }
    [schemas.cruise]
    type = "pace/cruise"
    period = "5ms"
    actuators = { base = "base.velocity" }
"#;

const BRAKED: &str = r#"
    roots = ["stop", "cruise"]
    [schemas.base]
    type = "pace/base"
    [schemas.stop]
    type = "stop"
    imports = { laser = "base.laser" }
    actuators = { base = "base.velocity" }
    [schemas.cruise]
    type = "pace/cruise"
    period = "5ms"
    actuators = { base = "base.velocity" }
"#;

/// The time of a run, with up to a hundred obstacles.
const RUN: Duration = Duration::from_secs(5);
/// More runs than a thousand obstacles need.
const MOST_RUNS: usize = 20;

/// Computes on every processor until it is dropped.
struct BusyProcessors {
    ended: Arc<AtomicBool>,
    threads: Vec<std::thread::JoinHandle<()>>,
}

pub(crate) fn run(scope: &Scope) -> Result<Vec<Line>> {
    let stops = scope.either(100, 1_000);
    let mut lines = Vec::new();
    for is_busy in [false, true] {
        for (what, application) in [("`guard/footprint`", GUARDED), ("`stop`", BRAKED)] {
            let busy = is_busy.then(BusyProcessors::start);
            let delays = delays(scope, application, stops)?;
            drop(busy);
            let beside = if is_busy { ", all processors busy" } else { "" };
            let mean = delays.iter().sum::<u64>() as f64 / delays.len() as f64;
            let longest = delays.iter().max().copied().unwrap_or_default() as f64;
            let line = |name: String, time, goal: f64| {
                let what = format!("{what}, {name}{beside}");
                Line::new(what, Figure::Time(time), Goal::Below(Figure::millis(goal)))
            };
            lines.push(line("mean".to_owned(), mean, 3.0));
            lines.push(line(format!("longest of {}", delays.len()), longest, 10.0));
        }
    }
    Ok(lines)
}

/// Returns the time from each obstacle until the base stands, ns.
fn delays(scope: &Scope, application: &str, stops: usize) -> Result<Vec<u64>> {
    let mut delays = Vec::new();
    // Each run may begin with an obstacle before the system has placed the threads.
    for _ in 0..MOST_RUNS {
        let plugins = loaded::plugins(&scope.built);
        delays.extend(live::run_with(plugins, application, RUN)?.notes.concat());
        if delays.len() >= stops {
            return Ok(delays);
        }
    }
    bail!("the base met {} obstacles", delays.len());
}

impl BusyProcessors {
    fn start() -> Self {
        let ended = Arc::new(AtomicBool::new(false));
        let count = std::thread::available_parallelism().map_or(1, std::num::NonZero::get);
        let compute = |ended: Arc<AtomicBool>| {
            move || {
                while !ended.load(Ordering::Relaxed) {
                    std::hint::black_box(&ended);
                }
            }
        };
        let threads = (0..count).map(|_| std::thread::spawn(compute(Arc::clone(&ended))));
        Self {
            threads: threads.collect(),
            ended,
        }
    }
}

impl Drop for BusyProcessors {
    fn drop(&mut self) {
        self.ended.store(true, Ordering::Relaxed);
        for thread in self.threads.drain(..) {
            thread.join().expect("the thread returns");
        }
    }
}
