//! Gives up a runner's call from another thread, and creates another runner in its place.

use std::sync::Arc;

use jde_core::{Nanos, SchemaId};

use super::Runner;
use crate::engine::Engine;
use crate::instance::PortAccess;

/// Access to a runner that is inside a call.
#[derive(Clone)]
pub(crate) struct CallHandle {
    engine: Arc<Engine>,
    number: SchemaId,
    port_access: Arc<PortAccess>,
}

impl CallHandle {
    pub(super) fn new(engine: &Arc<Engine>, number: SchemaId, port_access: &Arc<PortAccess>) -> Self {
        Self {
            engine: Arc::clone(engine),
            number,
            port_access: Arc::clone(port_access),
        }
    }

    /// Gives up the call that runs since `since`. Returns a runner that takes over, of the build in force and
    /// without an instance yet. Returns `None` if the call cannot be given up now, for example because it has
    /// returned. `report` reports to the rules and receives the bytes of shared values that the call keeps.
    /// Until it returns, the call cannot return and no runner takes over.
    /// `guard` answers for a call that waits for its judgement; otherwise the schema itself does.
    pub(crate) fn give_up(
        &self,
        since: Nanos,
        guard: Option<SchemaId>,
        report: impl FnOnce(u64),
    ) -> Option<Runner> {
        let ports = self.port_access.give_up(since, |kept| {
            if let Some(guard) = guard {
                self.port_access.blame(guard);
            }
            report(kept);
        })?;
        let mut runner = Runner::with_ports(&self.engine, self.number, ports);
        runner.retime();
        Some(runner)
    }
}
