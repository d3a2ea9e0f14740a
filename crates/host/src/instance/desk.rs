//! Where an instance finds its ports, and the gate before them: every use of a port during a call passes it.
//!
//! A call that does not return may be given up, by another thread than its own. The gate is then closed: whatever the call
//! still asks for is refused, and a successor of the instance gets ports of its own. Waits for no call, only for a single use of
//! a port, and the caretaker of the executors not even for that.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError, TryLockError};

use jde_core::Nanos;

use super::ports::Ports;
use super::remains::Remains;

/// The ports of an instance, for as long as its calls are not given up.
pub(crate) struct Desk {
    gate: Mutex<Gate>,
    /// Calls may have looked at values since the last release. Written between calls, which follow each other.
    holds: AtomicBool,
}

enum Gate {
    Open {
        ports: Ports,
        /// Since when a call runs.
        call: Option<Nanos>,
    },
    /// A call was given up; what it may still look at or write to stays where it is.
    Closed { _remains: Remains },
}

impl Desk {
    pub(crate) fn new(ports: Ports) -> Self {
        let gate = Gate::Open { ports, call: None };
        Self {
            gate: Mutex::new(gate),
            holds: AtomicBool::new(true),
        }
    }

    /// Uses the ports, which nobody else does meanwhile; nothing if the call was given up.
    pub(crate) fn ports<R>(&self, body: impl FnOnce(&mut Ports) -> R) -> Option<R> {
        match &mut *self.lock() {
            Gate::Open { ports, .. } => Some(body(ports)),
            Gate::Closed { .. } => None,
        }
    }

    /// A call begins.
    pub(super) fn enter<R>(&self, now: Nanos, body: impl FnOnce(&mut Ports) -> R) -> Option<R> {
        match &mut *self.lock() {
            Gate::Open { ports, call } => {
                *call = Some(now);
                Some(body(ports))
            }
            Gate::Closed { .. } => None,
        }
    }

    /// The call returned; nothing if it was given up before. From here on it no longer can be.
    pub(super) fn leave<R>(&self, body: impl FnOnce(&mut Ports) -> R) -> Option<R> {
        match &mut *self.lock() {
            Gate::Open { ports, call } => {
                *call = None;
                let left = body(ports);
                self.holds.store(ports.holds(), Ordering::Release);
                Some(left)
            }
            Gate::Closed { .. } => None,
        }
    }

    /// Lets go of the values that calls have looked at, if there are any.
    pub(super) fn release(&self) {
        if self.holds.load(Ordering::Acquire) {
            self.ports(Ports::release);
            self.holds.store(false, Ordering::Release);
        }
    }

    /// Time of the newest value that calls have looked at since the last release; 0 if they looked at none.
    pub(super) fn newest(&self) -> Nanos {
        if !self.holds.load(Ordering::Acquire) {
            return 0;
        }
        self.ports(|ports| ports.newest()).unwrap_or_default()
    }

    /// Whether a call was given up.
    pub(super) fn is_closed(&self) -> bool {
        matches!(*self.lock(), Gate::Closed { .. })
    }

    /// Gives up the call that runs since then, and answers with ports for a successor. Nothing if it has returned, if a port is
    /// being used at this instant, or if what it borrowed cannot be left to it yet: try again then. `tell` is told how many bytes
    /// the call keeps, while it can neither return nor use a port.
    pub(crate) fn give_up(&self, since: Nanos, tell: impl FnOnce(u64)) -> Option<Ports> {
        let mut gate = match self.gate.try_lock() {
            Ok(gate) => gate,
            Err(TryLockError::Poisoned(poisoned)) => poisoned.into_inner(),
            Err(TryLockError::WouldBlock) => return None,
        };
        let Gate::Open { ports, call } = &mut *gate else {
            return None;
        };
        if *call != Some(since) {
            return None;
        }
        let (successor, remains) = match ports.hand_on() {
            Ok(handed) => handed,
            Err(error) => {
                tracing::warn!("a call that hangs cannot be given up yet: {error}");
                return None;
            }
        };
        let bytes = remains.bytes();
        *gate = Gate::Closed { _remains: remains };
        tell(bytes as u64);
        Some(successor)
    }

    /// A panic while it was held was the host's own, and ends the application.
    fn lock(&self) -> MutexGuard<'_, Gate> {
        self.gate.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
