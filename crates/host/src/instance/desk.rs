//! Where an instance finds its ports, and the gate before them: every use of a port during a call passes it.
//!
//! A call that does not return may be given up, by another thread than its own. The gate is then closed: whatever the call
//! still asks for is refused, and a successor of the instance gets ports of its own. Waits for no call, only for a single use of
//! a port, and the caretaker of the executors not even for that.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError, TryLockError};

use jde_core::Nanos;

use super::ports::Ports;
use super::remains::Remains;

/// The ports of an instance, for as long as its calls are not given up.
///
/// A call ends once: either it returns, or it is given up. Who gives it up holds the gate, and whoever leaves without having touched
/// anything that must be put in order takes the word of `call` alone.
pub(crate) struct Desk {
    gate: Mutex<Gate>,
    /// Since when a call runs, plus one; or one of the words below.
    call: AtomicU64,
    /// Calls may have looked at values since the last release.
    holds: AtomicBool,
    /// The call may have loaned what it did not publish.
    lends: AtomicBool,
    /// Somebody wants to know what is looked at.
    followed: bool,
}

/// No call runs.
const NONE: u64 = 0;
/// The call is being given up.
const GIVING: u64 = u64::MAX - 1;
/// The call was given up.
const CLOSED: u64 = u64::MAX;

enum Gate {
    Open(Ports),
    /// A call was given up; what it may still look at or write to stays where it is.
    Closed {
        _remains: Remains,
    },
}

impl Desk {
    pub(crate) fn new(ports: Ports) -> Self {
        Self {
            followed: ports.looks().is_some(),
            gate: Mutex::new(Gate::Open(ports)),
            call: AtomicU64::new(NONE),
            holds: AtomicBool::new(true),
            lends: AtomicBool::new(true),
        }
    }

    /// Uses the ports, which nobody else does meanwhile; nothing if the call was given up.
    pub(crate) fn ports<R>(&self, body: impl FnOnce(&mut Ports) -> R) -> Option<R> {
        match &mut *self.lock() {
            Gate::Open(ports) => {
                let done = body(ports);
                self.note(ports);
                Some(done)
            }
            Gate::Closed { .. } => None,
        }
    }

    /// A call begins. For those who want to know, the last transaction.
    pub(super) fn enter(&self, now: Nanos) -> Option<u64> {
        // Only this thread begins and ends calls here; whoever gives one up finds none to give up.
        if self.is_closed() {
            return None;
        }
        self.call.store(now + 1, Ordering::Release);
        if self.followed {
            self.ports(Ports::enter).flatten()
        } else {
            None
        }
    }

    /// The call returned, and leaves its ports in order; false if it was given up before. From here on it no longer can be.
    pub(super) fn leave(&self, tidy: impl FnOnce(&mut Ports)) -> bool {
        if !self.followed && !self.lends.load(Ordering::Acquire) {
            let call = self.call.load(Ordering::Acquire);
            let swap = || {
                self.call
                    .compare_exchange(call, NONE, Ordering::AcqRel, Ordering::Acquire)
            };
            if call < GIVING && swap().is_ok() {
                return true;
            }
        }
        // Whoever is giving it up has finished when the gate is free.
        match &mut *self.lock() {
            Gate::Open(ports) => {
                self.call.store(NONE, Ordering::Release);
                tidy(ports);
                self.note(ports);
                true
            }
            Gate::Closed { .. } => false,
        }
    }

    /// Lets go of the values that calls have looked at, if there are any.
    pub(super) fn release(&self) {
        if self.holds.load(Ordering::Acquire) {
            self.ports(Ports::release);
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
        self.call.load(Ordering::Acquire) == CLOSED
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
        let Gate::Open(ports) = &mut *gate else {
            return None;
        };
        self.call
            .compare_exchange(since + 1, GIVING, Ordering::AcqRel, Ordering::Acquire)
            .ok()?;
        let (successor, remains) = match ports.hand_on() {
            Ok(handed) => handed,
            Err(error) => {
                self.call.store(since + 1, Ordering::Release);
                tracing::warn!("a call that hangs cannot be given up yet: {error}");
                return None;
            }
        };
        let bytes = remains.bytes();
        *gate = Gate::Closed { _remains: remains };
        self.call.store(CLOSED, Ordering::Release);
        tell(bytes as u64);
        Some(successor)
    }

    /// Notes what there is to put in order.
    fn note(&self, ports: &Ports) {
        self.holds.store(ports.holds(), Ordering::Release);
        self.lends.store(ports.lends(), Ordering::Release);
    }

    /// A panic while it was held was the host's own, and ends the application.
    fn lock(&self) -> MutexGuard<'_, Gate> {
        self.gate.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Barrier;
    use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};

    use super::*;

    #[test]
    fn a_call_ends_once_whoever_ends_it() {
        const ROUNDS: usize = 2000;
        let (left, given_up) = (AtomicUsize::new(0), AtomicUsize::new(0));
        for round in 0..ROUNDS {
            let desk = Desk::new(Ports::new(Vec::new()));
            if round % 2 == 0 {
                // Nothing to put in order: it leaves by its word alone.
                desk.ports(|_| ());
            }
            desk.enter(7);
            let both = Barrier::new(2);
            std::thread::scope(|scope| {
                scope.spawn(|| {
                    both.wait();
                    left.fetch_add(usize::from(desk.leave(|_| ())), Relaxed);
                });
                both.wait();
                let ports = desk.give_up(7, |_| ());
                given_up.fetch_add(usize::from(ports.is_some()), Relaxed);
            });
            assert_eq!(left.load(Relaxed) + given_up.load(Relaxed), round + 1);
        }
    }

    #[test]
    fn who_was_given_up_neither_returns_nor_uses_a_port() {
        let desk = Desk::new(Ports::new(Vec::new()));
        desk.enter(7);
        assert!(desk.give_up(8, |_| ()).is_none(), "that call does not run");
        assert!(desk.give_up(7, |_| ()).is_some());
        assert!(desk.is_closed());
        assert!(desk.ports(|_| ()).is_none());
        assert!(!desk.leave(|_| ()));
        assert_eq!(desk.enter(9), None);
        assert!(desk.is_closed(), "nobody enters any more");
    }
}
