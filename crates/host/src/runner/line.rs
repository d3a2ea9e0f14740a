//! A line to a runner that is inside a call: enough to give that call up and to put another runner in its place.

use std::sync::Arc;

use jde_core::Nanos;

use super::Runner;
use crate::engine::Engine;
use crate::instance::Desk;

/// What can be done about a runner that is inside a call.
#[derive(Clone)]
pub(crate) struct Line {
    engine: Arc<Engine>,
    number: usize,
    desk: Arc<Desk>,
}

impl Line {
    pub(super) fn new(engine: &Arc<Engine>, number: usize, desk: &Arc<Desk>) -> Self {
        Self {
            engine: Arc::clone(engine),
            number,
            desk: Arc::clone(desk),
        }
    }

    /// Gives up the call that runs since then: answers with a runner that takes over, of the build that is in force, without an
    /// instance yet. Nothing if it cannot be given up now, for one because it has returned. `tell` says so to the rules; it is told
    /// how many bytes of shared values the call keeps, and neither the call can return nor anybody take over before it is done.
    pub(crate) fn give_up(&self, since: Nanos, tell: impl FnOnce(u64)) -> Option<Runner> {
        let ports = self.desk.give_up(since, tell)?;
        let mut runner = Runner::with(&self.engine, self.number, ports);
        runner.retime();
        Some(runner)
    }
}
