//! Calls that do not return. A call that was given up may run for ever, but nothing it does has an effect,
//! and the number of such calls is bounded and counted.

use std::sync::atomic::Ordering::Relaxed;

use jde_core::{Health, Nanos};

use super::{Engine, Signal, schema};
use crate::event::Event;
use crate::footprint::Footprint;
use crate::instance::Left;

/// The limit of calls of one schema that were given up and have not returned. Each keeps a thread, its stack,
/// and the memory and files of the schema. A few are tolerated; a schema that always hangs must not exhaust
/// the machine.
const MOST_LEFT: u64 = 4;

impl Engine {
    /// Whether an instance may be created.
    ///
    /// # Errors
    /// Too many calls of earlier instances were given up and never returned.
    pub(crate) fn may_make(&self, instance: usize) -> Result<(), String> {
        let left = self.meters[instance].left.load(Relaxed);
        if left < MOST_LEFT {
            return Ok(());
        }
        Err(format!(
            "{left} calls of it were given up and never returned; it gets no other instance until one does"
        ))
    }

    /// Reports that a call does not return: the level selects again as after a failure. If the call could not
    /// be given up and still runs at a restart, the restart fails too.
    pub(crate) fn hung(&self, instance: usize, reason: String) {
        let known = matches!(self.lock().hierarchy.health(schema(instance)), Health::Faulted(_));
        if !known {
            // Marks a death of the process as reported: a later discovery of it must not report it again.
            self.processes.is_to_be_told(instance);
            self.died(instance, reason);
        }
    }

    /// Reports that the call which runs since `since` was given up for `reason`; it keeps `kept` bytes of
    /// shared values.
    pub(crate) fn left_behind(&self, instance: usize, since: Nanos, reason: String, kept: u64) {
        let meter = &self.meters[instance];
        meter.leave();
        let left = meter.left.fetch_add(1, Relaxed) + 1;
        // First, so that the next instance is created from the right build.
        self.interrupted(instance, &reason);
        self.hung(instance, reason);
        // The instance may have faulted long before and published values since.
        self.variables.retract_exports(instance);
        self.transact_end(None, instance);
        if self.builds.is_awaited(instance) {
            // The call may have taken the signal from the inbox and hung before the exchange.
            self.ring(instance, Signal::Swapped);
        }
        let process = Footprint::now();
        tracing::warn!(
            schema = self.name(instance),
            "a call that hangs is left behind; {left} of its calls are, and the process has {process}"
        );
        self.report(&Event::LeftBehind {
            time: self.clock.now(),
            schema: instance,
            since,
            left,
            kept,
            process,
        });
    }

    /// Ends the instance of a call that was given up and has now returned, on the calling thread.
    pub(crate) fn came_back(&self, left: Left) {
        let (instance, since) = (left.number, left.since);
        left.end();
        let left = self.meters[instance].left.fetch_sub(1, Relaxed) - 1;
        self.report(&Event::CameBack {
            time: self.clock.now(),
            schema: instance,
            since,
            left,
            process: Footprint::now(),
        });
    }
}
