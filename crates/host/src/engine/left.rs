//! Calls that do not return. Those that were given up may run on for ever, but nothing they do counts, and how many there are is
//! bounded and known.

use std::sync::atomic::Ordering::Relaxed;

use jde_core::{Health, Nanos};

use super::{Engine, Signal, schema};
use crate::event::Event;
use crate::footprint::Footprint;
use crate::instance::Left;

/// Calls of one schema that may have been given up and not have returned: each keeps a thread, its stack and whatever the
/// schema had allocated and opened. Who hangs once in a while is helped by a few; who always does must not eat the machine.
const MOST_LEFT: u64 = 4;

impl Engine {
    /// Whether an instance may be made.
    ///
    /// # Errors
    /// Too many calls of those before it never returned.
    pub(crate) fn may_make(&self, instance: usize) -> Result<(), String> {
        let left = self.meters[instance].left.load(Relaxed);
        if left < MOST_LEFT {
            return Ok(());
        }
        Err(format!(
            "{left} calls of it were given up and never returned; it gets no other instance until one does"
        ))
    }

    /// A call does not return: the level selects again as if it had failed. A restart that finds it there still, because it could
    /// not be given up, fails too.
    pub(crate) fn hung(&self, instance: usize, reason: String) {
        let known = matches!(self.lock().hierarchy.health(schema(instance)), Health::Faulted(_));
        if !known {
            // Who finds out later that a process has died need not tell.
            self.processes.is_to_be_told(instance);
            self.died(instance, reason);
        }
    }

    /// The call of an instance that has run since then was given up for that reason, and keeps so many bytes of shared values.
    pub(crate) fn left_behind(&self, instance: usize, since: Nanos, reason: String, kept: u64) {
        let meter = &self.meters[instance];
        meter.leave();
        let left = meter.left.fetch_add(1, Relaxed) + 1;
        // First, so that whoever makes the next instance finds the build that it is to be of.
        self.interrupted(instance, &reason);
        self.hung(instance, reason);
        // It may have faulted long before, and have published since.
        self.variables.retract_exports(instance);
        self.transact_end(None, instance);
        if self.builds.is_awaited(instance) {
            // The call may have taken up the signal for it, and hung before its turn.
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

    /// A call returned that was given up: its instance ends, here and now.
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
