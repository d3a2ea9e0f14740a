//! Applications of linked-in schemas in real time, for so long. Measures nothing itself.

use std::time::Duration;

use anyhow::Result;
use jde_host::{Options, Running};

use crate::{loaded, schemas};

/// What a run left.
pub(crate) struct Run {
    /// What its schemas noted, one list each.
    pub(crate) notes: Vec<Vec<u64>>,
    /// Processor time of the process while it ran, ns.
    pub(crate) processor: u64,
    /// Deadlines that were missed.
    pub(crate) missed: u64,
}

/// Runs an application for that long.
pub(crate) fn run(text: &str, time: Duration) -> Result<Run> {
    let plugins = schemas::plugins()?;
    let application = loaded::application(text, &plugins)?;
    schemas::notes();
    let running = Running::start(application, &plugins, Options::default())?;
    let before = crate::bare::processor_time();
    std::thread::sleep(time);
    let processor = crate::bare::processor_time() - before;
    let missed = running
        .handle()
        .snapshot()
        .schemas
        .iter()
        .map(|schema| schema.overruns)
        .sum();
    drop(running);
    Ok(Run {
        notes: schemas::notes(),
        processor,
        missed,
    })
}
