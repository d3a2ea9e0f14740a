//! Runs applications of linked-in schemas and of further plugins in real time for a given time. Measures only
//! processor time and missed deadlines.

use std::sync::{Arc, OnceLock};
use std::time::Duration;

use anyhow::{Context as _, Result};
use jde_core::{Nanos, State};
use jde_host::{Options, Running};
use jde_loader::{Plugins, SearchPath};
use jde_records::event::{Event, Observer, StateChange};

use crate::{loaded, schemas};

/// The time until all schemas are awake and on their grids. It is not part of the measurement.
pub(crate) const START: Duration = Duration::from_millis(200);

/// The result of a run.
pub(crate) struct Run {
    /// The notes of its schemas, one list each.
    pub(crate) notes: Vec<Vec<u64>>,
    /// When the first schema was woken, ns of the application's time.
    pub(crate) woken: Nanos,
    /// Processor time of the process during the measurement, ns.
    pub(crate) processor: u64,
    /// Deadlines that were missed during the measurement.
    pub(crate) missed: u64,
}

/// Records when the first schema is woken.
struct FirstWoken(Arc<OnceLock<Nanos>>);

impl Observer for FirstWoken {
    fn on_event(&mut self, event: &Event) {
        if let Event::State(StateChange {
            time,
            from: State::Slept,
            ..
        }) = event
        {
            // Only the first time is kept. The others are woken at the same instant.
            let _ = self.0.set(*time);
        }
    }
}

/// Runs an application of the benches' schemas for [`START`] and then for `time`.
pub(crate) fn run(text: &str, time: Duration) -> Result<Run> {
    run_with(Plugins::new(SearchPath::default()), text, time)
}

/// Runs an application as [`run`] does, with the schemas of further plugins.
pub(crate) fn run_with(mut plugins: Plugins, text: &str, time: Duration) -> Result<Run> {
    plugins.link(&schemas::PLUGIN)?;
    let application = loaded::application(text, &plugins)?;
    schemas::notes();
    let woken = Arc::new(OnceLock::new());
    let options = Options {
        observers: vec![Box::new(FirstWoken(Arc::clone(&woken)))],
        ..Options::default()
    };
    let running = Running::start(application, &plugins, options)?;
    std::thread::sleep(START);
    let missed = || {
        let schemas = running.handle().snapshot().schemas;
        schemas.iter().map(|schema| schema.overruns).sum::<u64>()
    };
    let before = (crate::bare::processor_time(), missed());
    std::thread::sleep(time);
    let processor = crate::bare::processor_time() - before.0;
    let missed = missed() - before.1;
    drop(running);
    Ok(Run {
        notes: schemas::notes(),
        woken: woken.get().copied().context("no schema was woken")?,
        processor,
        missed,
    })
}
