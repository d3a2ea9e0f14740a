//! The time from the scan that shows an obstacle to the driver that stands, by a guard and by `stop`: alone, beside a
//! thread that computes, and beside as many as there are processors. Devices and networks are not part of it.

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

/// Threads that compute until this is dropped.
struct BusyThreads {
    ended: Arc<AtomicBool>,
    threads: Vec<std::thread::JoinHandle<()>>,
}

pub(crate) fn run(scope: &Scope) -> Result<Vec<Line>> {
    let stops = scope.either(100, 1_000);
    let processors = std::thread::available_parallelism().map_or(1, std::num::NonZero::get);
    let mut lines = Vec::new();
    for (beside, busy, is_goal) in [
        ("", 0, true),
        (", one processor busy", 1, true),
        (", all processors busy", processors, false),
    ] {
        for (what, application) in [("`guard/footprint`", GUARDED), ("`stop`", BRAKED)] {
            let busy = BusyThreads::start(busy);
            let delays = delays(scope, application, stops)?;
            drop(busy);
            let mean = delays.iter().sum::<u64>() as f64 / delays.len() as f64;
            let longest = delays.iter().max().copied().unwrap_or_default() as f64;
            let mut add = |name: &str, time, most| {
                let goal = match is_goal {
                    true => Goal::Below(Figure::millis(most)),
                    false => Goal::ReportOnly,
                };
                let line = Line::new(format!("{what}{beside}, {name}"), Figure::Time(time), goal);
                lines.push(line);
            };
            add("mean", mean, 3.0);
            add(&format!("longest of {}", delays.len()), longest, 10.0);
        }
    }
    Ok(lines)
}

/// Returns the time from each obstacle until the base stands, ns.
fn delays(scope: &Scope, application: &str, stops: usize) -> Result<Vec<u64>> {
    let mut delays = Vec::new();
    // Several runs, since the system places the threads of each anew.
    for _ in 0..MOST_RUNS {
        let plugins = loaded::plugins(&scope.built);
        delays.extend(live::run_with(plugins, application, RUN)?.notes.concat());
        if delays.len() >= stops {
            return Ok(delays);
        }
    }
    bail!("the base met {} obstacles", delays.len());
}

impl BusyThreads {
    fn start(count: usize) -> Self {
        let ended = Arc::new(AtomicBool::new(false));
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

impl Drop for BusyThreads {
    fn drop(&mut self) {
        self.ended.store(true, Ordering::Relaxed);
        for thread in self.threads.drain(..) {
            thread.join().expect("the thread returns");
        }
    }
}
