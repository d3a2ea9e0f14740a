//! The executor of a run, and what is kept while time passes.

use std::collections::BTreeMap;
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use jde_core::{Nanos, SchemaId};
use jde_host::{Handle, Lockstep, PanelViewGuard};

use crate::observation::Observation;
use crate::run::{FOREVER, Shared, Stop};

/// The machine time after which a run in lockstep looks whether others wait for its state.
pub(crate) const SLICE: Duration = Duration::from_millis(20);
/// The time that passes between two looks at the clock of the machine, ns.
const MAX_STRIDE: Nanos = 1_000_000_000;

/// What carries an application out.
pub(crate) enum Executor {
    /// The calls that let time pass.
    Lockstep(Lockstep),
    /// Threads of its own, and the one that brings them to rest when the application ends.
    RealTime(JoinHandle<()>),
    /// Nothing any more.
    AtRest,
}

/// The state of a run that its calls share.
pub(crate) struct State {
    pub(crate) executor: Executor,
    pub(crate) observation: Option<Observation>,
    /// The panels that are drawn, by their schemas.
    pub(crate) panels: BTreeMap<SchemaId, PanelViewGuard>,
}

impl State {
    /// Runs in lockstep until a time, or until a condition is true. Returns `None` after [`SLICE`].
    pub(crate) fn advance(&mut self, shared: &Shared, end: Nanos, condition: Option<u64>) -> Option<Stop> {
        let started = Instant::now();
        loop {
            let Executor::Lockstep(lockstep) = &mut self.executor else {
                return Some(Stop::End);
            };
            let lease = shared.lease().end();
            let due = next_instant(lockstep, &shared.handle)
                .into_iter()
                .chain(lease)
                .min();
            if due.is_none() && end == FOREVER {
                return Some(Stop::Time);
            }
            let mut next = due.unwrap_or(end);
            if self.observation.is_none() && lease.is_none() {
                // Nothing looks at the instants in between.
                next = next.saturating_add(MAX_STRIDE);
            }
            let next = next.min(end);
            let outcome = lockstep.run_until(next);
            self.observe(shared);
            if self.was_true(condition) {
                return Some(Stop::Condition);
            }
            if outcome.is_some() {
                return Some(Stop::End);
            }
            if next >= end {
                return Some(Stop::Time);
            }
            if started.elapsed() > SLICE {
                return None;
            }
        }
    }

    /// Keeps what has changed until now, and ends what is held under a lease that has ended.
    pub(crate) fn observe(&mut self, shared: &Shared) {
        let now = shared.handle.now();
        shared.lease().check(now, &shared.operator);
        if let Some(observation) = &mut self.observation {
            observation.observe(now);
        }
    }

    /// Whether a condition has been true since somebody waits for it.
    pub(crate) fn was_true(&self, condition: Option<u64>) -> bool {
        let observation = self.observation.as_ref();
        condition.is_some_and(|number| observation.is_some_and(|observation| observation.was_true(number)))
    }
}

/// Returns the time of the next instant at which anything is due.
pub(crate) fn next_instant(lockstep: &mut Lockstep, handle: &Handle) -> Option<Nanos> {
    lockstep.next_instant().or_else(|| {
        // What an operator has done since is processed at the present time, and may make a schema due.
        lockstep.run_until(handle.now());
        lockstep.next_instant()
    })
}
