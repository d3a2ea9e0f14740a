//! An instance that a mock takes the place of: its calls publish the mock's values. It calls no plugin and
//! reads no port.

use std::sync::Arc;

use jde_abi::host::Host as _;
use jde_abi::raw;
use jde_core::Nanos;
use jde_loader::instance::{ArbitrationQuery, Verdict};

use super::CallContext;
use crate::mock::ResolvedMock;

pub(crate) struct MockedInstance {
    mock: Arc<ResolvedMock>,
    /// How many values of each track were in force at the last publication.
    published: Vec<usize>,
}

impl MockedInstance {
    pub(super) fn new(mock: &Arc<ResolvedMock>) -> Self {
        Self {
            published: vec![0; mock.tracks.len()],
            mock: Arc::clone(mock),
        }
    }

    pub(super) fn check(&self, call: &mut CallContext<'_>) -> (i32, bool, f64) {
        let (ready, urgency) = self.mock.precondition(call.now());
        (raw::OK, ready, urgency)
    }

    /// Publishes what is due, and wakes all children. What is refused is reported by the host, as for any
    /// schema; an optional port may be unbound.
    pub(super) fn iterate(&mut self, call: &mut CallContext<'_>) -> i32 {
        let now = call.now();
        for (track, published) in self.mock.tracks.iter().zip(&mut self.published) {
            let reached = track.reached(now);
            let is_new = std::mem::replace(published, reached) != reached;
            let Some((from, value)) = reached.checked_sub(1).map(|last| &track.values[last]) else {
                continue;
            };
            match value {
                Some(value) if track.repeats => publish(call, track.port, value, now),
                Some(value) if is_new => publish(call, track.port, value, *from),
                None if is_new => drop(call.retract(track.port)),
                Some(_) | None => {}
            }
        }
        for (port, value) in &self.mock.live {
            value.with(|value| publish(call, *port, value, now));
        }
        for role in 0..call.build.roles() as u32 {
            call.wake(role);
        }
        raw::OK
    }

    /// Chooses the first candidate that is ready: the father names the children in the order of priority.
    pub(super) fn arbitrate(query: &ArbitrationQuery) -> (i32, Verdict) {
        let ready = query.candidates.iter().find(|candidate| candidate.ready);
        let verdict = Verdict {
            child: ready.map(|candidate| candidate.child),
            reason: String::from("a mock chooses by priority"),
        };
        (raw::OK, verdict)
    }
}

fn publish(call: &mut CallContext<'_>, port: u32, value: &[u8], time: Nanos) {
    if call.lend(port, |buffer| buffer.copy_from_slice(value)).is_ok() {
        call.publish(port, time);
    }
}
