//! What calls use, and what can be taken from a call that hangs.
//!
//! A schema's call reads and writes its ports. If it does not return, another thread than its own takes the ports away: whatever
//! the call still asks for is refused, and a successor of the schema gets ports of its own. A [`Gate`] stands between the two.
//! Every use passes it, and a call ends once: either it returns, or it is given up.
//!
//! It knows nothing of ports or schemas, and starts no thread.
//!
//! ```
//! use jde_gate::Gate;
//!
//! // What is used is a list here; what stays with a call that is given up is its length.
//! let gate: Gate<Vec<i32>, usize> = Gate::new(vec![1]);
//! assert!(gate.enter(7));
//! assert_eq!(gate.with(|list| list.push(2)), Some(()));
//! // The call that began at 7 hangs. Somebody else gives it up:
//! let successor = gate.give_up(7, |list| Ok::<_, ()>((vec![0], list.len())), |kept| assert_eq!(*kept, 2));
//! assert_eq!(successor, Ok(Some(vec![0])));
//! // It wakes after all, and can neither go on nor return:
//! assert_eq!(gate.with(|list| list.push(3)), None);
//! assert!(!gate.leave(|_| ()));
//! ```

mod sync;

use std::sync::{PoisonError, TryLockError};

use sync::{AtomicU64, Mutex, MutexGuard, Ordering};

/// What the calls of one schema use (`T`), as long as none of them was given up; then what must outlive that call (`R`).
///
/// One thread at a time makes calls; any thread may give one up. Nobody waits for a call, only for a single use, and whoever
/// gives up not even for that. A call that leaves nothing to put in order returns without the lock.
#[derive(Debug)]
pub struct Gate<T, R> {
    inside: Mutex<Inside<T, R>>,
    /// Since when a call runs, plus one; or one of the words below.
    call: AtomicU64,
}

/// No call runs.
const NONE: u64 = 0;
/// The call is being given up, by whoever has the lock.
const GIVING: u64 = u64::MAX - 1;
/// The call was given up.
const CLOSED: u64 = u64::MAX;

#[derive(Debug)]
enum Inside<T, R> {
    Open(T),
    Closed {
        /// Dropped with the gate, which the call itself keeps.
        remains: R,
    },
}

impl<T, R> Gate<T, R> {
    /// Open, with no call running.
    pub fn new(used: T) -> Self {
        Self {
            inside: Mutex::new(Inside::Open(used)),
            call: AtomicU64::new(NONE),
        }
    }

    /// A call begins, then: any number but the three largest. False if one was given up: nobody enters any more.
    pub fn enter(&self, since: u64) -> bool {
        debug_assert!(since < GIVING - 1, "the words of the gate are no times");
        // Only this thread begins and ends calls here; whoever gives one up finds none to give up.
        if self.is_closed() {
            return false;
        }
        self.call.store(since + 1, Ordering::Release);
        true
    }

    /// Uses what is inside, which nobody else does meanwhile; nothing if the call was given up.
    pub fn with<U>(&self, body: impl FnOnce(&mut T) -> U) -> Option<U> {
        match &mut *self.lock() {
            Inside::Open(used) => Some(body(used)),
            Inside::Closed { .. } => None,
        }
    }

    /// The call returns, and leaves nothing to put in order. False if it is being given up, or was: ask [`Self::leave`] then.
    pub fn leave_at_once(&self) -> bool {
        let call = self.call.load(Ordering::Acquire);
        let swap = || {
            self.call
                .compare_exchange(call, NONE, Ordering::AcqRel, Ordering::Acquire)
        };
        call < GIVING && swap().is_ok()
    }

    /// The call returns, and puts in order what is inside; false if it was given up before. From here on it no longer can be.
    pub fn leave(&self, tidy: impl FnOnce(&mut T)) -> bool {
        // Whoever is giving it up has finished when the lock is free.
        match &mut *self.lock() {
            Inside::Open(used) => {
                self.call.store(NONE, Ordering::Release);
                tidy(used);
                true
            }
            Inside::Closed { .. } => false,
        }
    }

    /// Whether a call was given up.
    pub fn is_closed(&self) -> bool {
        self.call.load(Ordering::Acquire) == CLOSED
    }

    /// Gives up the call that runs since then. `part` answers what a successor gets and what stays with the call; `told` is told
    /// of the latter, while the call can neither return nor use anything. Nothing if that call has returned, or if something is
    /// being used at this instant: try again then.
    ///
    /// # Errors
    /// As `part`'s, which must leave the call what it had: it goes on as if nothing had happened.
    pub fn give_up<S, E>(
        &self,
        since: u64,
        part: impl FnOnce(&mut T) -> Result<(S, R), E>,
        told: impl FnOnce(&R),
    ) -> Result<Option<S>, E> {
        let mut inside = match self.inside.try_lock() {
            Ok(inside) => inside,
            Err(TryLockError::Poisoned(poisoned)) => poisoned.into_inner(),
            Err(TryLockError::WouldBlock) => return Ok(None),
        };
        let Inside::Open(used) = &mut *inside else {
            return Ok(None);
        };
        let giving = self
            .call
            .compare_exchange(since + 1, GIVING, Ordering::AcqRel, Ordering::Acquire);
        if giving.is_err() {
            return Ok(None);
        }
        match part(used) {
            Ok((successor, remains)) => {
                *inside = Inside::Closed { remains };
                self.call.store(CLOSED, Ordering::Release);
                if let Inside::Closed { remains } = &*inside {
                    told(remains);
                }
                Ok(Some(successor))
            }
            Err(error) => {
                self.call.store(since + 1, Ordering::Release);
                Err(error)
            }
        }
    }

    /// A panic while it was held was that of whoever used it, and is not made worse here.
    fn lock(&self) -> MutexGuard<'_, Inside<T, R>> {
        self.inside.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
