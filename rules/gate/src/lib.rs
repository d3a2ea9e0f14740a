//! Access of calls to their ports, and its removal from a call that hangs.
//!
//! A schema's call reads and writes its ports. If it does not return, another thread removes its access:
//! all further accesses of the call are refused, and a successor of the schema gets its own ports. A
//! [`Gate`] separates the two. Every use passes through it. A call ends once: it returns, or it is given up.
//!
//! The crate does not depend on ports or schemas, and starts no thread.
//!
//! ```
//! use jde_gate::Gate;
//!
//! // In this example the data is a list, and its length remains with a call that is given up.
//! let gate: Gate<Vec<i32>, usize> = Gate::new(vec![1]);
//! assert!(gate.enter(7));
//! assert_eq!(gate.with(|list| list.push(2)), Some(()));
//! // The call that began at 7 hangs. Another thread gives it up:
//! let successor = gate.give_up(7, |list| Ok::<_, ()>((vec![0], list.len())), |kept| assert_eq!(*kept, 2));
//! assert_eq!(successor, Ok(Some(vec![0])));
//! // If the call continues later, it can neither use the data nor return normally:
//! assert_eq!(gate.with(|list| list.push(3)), None);
//! assert!(!gate.finish(|_| ()));
//! ```

mod sync;

use std::sync::{PoisonError, TryLockError};

use sync::{AtomicU64, Mutex, MutexGuard, Ordering};

/// The data that the calls of one schema use (`T`), until one of them is given up. Then the data that must
/// outlive that call (`R`).
///
/// One thread at a time makes calls; any thread may give one up. No thread waits for a call, only for a
/// single use, and a thread that gives up a call does not even wait for that. A call without anything to
/// clean up returns without the lock.
#[derive(Debug)]
pub struct Gate<T, R> {
    state: Mutex<State<T, R>>,
    /// The start of the running call plus one, or one of the constants below.
    call: AtomicU64,
}

/// No call runs.
const NO_CALL: u64 = 0;
/// The holder of the lock is giving up the call.
const GIVING_UP: u64 = u64::MAX - 1;
/// The call was given up.
const CALL_GIVEN_UP: u64 = u64::MAX;

#[derive(Debug)]
enum State<T, R> {
    Open(T),
    Closed {
        /// Dropped with the gate, which the call itself keeps alive.
        remains: R,
    },
}

impl<T, R> Gate<T, R> {
    /// Returns an open gate without a running call.
    pub fn new(used: T) -> Self {
        Self {
            state: Mutex::new(State::Open(used)),
            call: AtomicU64::new(NO_CALL),
        }
    }

    /// Begins a call at `since`, which may be any number but the three largest. Returns false if a call was
    /// given up: then no call can begin any more.
    pub fn enter(&self, since: u64) -> bool {
        debug_assert!(since < GIVING_UP - 1, "the largest numbers are reserved");
        // Only this thread begins calls, so no other thread can give up a call at this point.
        if self.is_closed() {
            return false;
        }
        self.call.store(since + 1, Ordering::Release);
        true
    }

    /// Runs `body` with exclusive access to the data. Returns `None` if the call was given up.
    pub fn with<U>(&self, body: impl FnOnce(&mut T) -> U) -> Option<U> {
        match &mut *self.lock() {
            State::Open(used) => Some(body(used)),
            State::Closed { .. } => None,
        }
    }

    /// Ends the call without any clean-up. Returns false if it was given up, or is being given up:
    /// use [`Self::finish`] then.
    pub fn try_finish(&self) -> bool {
        let call = self.call.load(Ordering::Acquire);
        let swap = || {
            self.call
                .compare_exchange(call, NO_CALL, Ordering::AcqRel, Ordering::Acquire)
        };
        call < GIVING_UP && swap().is_ok()
    }

    /// Ends the call and cleans up the data. Returns false if it was given up before. Afterwards it cannot be
    /// given up.
    pub fn finish(&self, clean_up: impl FnOnce(&mut T)) -> bool {
        // When the lock is free, a thread that was giving up the call has finished.
        match &mut *self.lock() {
            State::Open(used) => {
                self.call.store(NO_CALL, Ordering::Release);
                clean_up(used);
                true
            }
            State::Closed { .. } => false,
        }
    }

    /// Returns whether a call was given up.
    pub fn is_closed(&self) -> bool {
        self.call.load(Ordering::Acquire) == CALL_GIVEN_UP
    }

    /// Gives up the call that runs since `since`. `split` returns the data of a successor and the data that
    /// remains with the call. `notify` gets the latter, while the call can neither return nor use anything.
    /// Returns `None` if that call has returned, or if the data is in use at this instant: retry then.
    ///
    /// # Errors
    /// The error of `split`, which must then not change the data: the call continues as before.
    pub fn give_up<S, E>(
        &self,
        since: u64,
        split: impl FnOnce(&mut T) -> Result<(S, R), E>,
        notify: impl FnOnce(&R),
    ) -> Result<Option<S>, E> {
        let mut state = match self.state.try_lock() {
            Ok(state) => state,
            Err(TryLockError::Poisoned(poisoned)) => poisoned.into_inner(),
            Err(TryLockError::WouldBlock) => return Ok(None),
        };
        let State::Open(used) = &mut *state else {
            return Ok(None);
        };
        let claimed = self
            .call
            .compare_exchange(since + 1, GIVING_UP, Ordering::AcqRel, Ordering::Acquire);
        if claimed.is_err() {
            return Ok(None);
        }
        match split(used) {
            Ok((successor, remains)) => {
                *state = State::Closed { remains };
                self.call.store(CALL_GIVEN_UP, Ordering::Release);
                if let State::Closed { remains } = &*state {
                    notify(remains);
                }
                Ok(Some(successor))
            }
            Err(error) => {
                self.call.store(since + 1, Ordering::Release);
                Err(error)
            }
        }
    }

    /// A panic under the lock was reported by the use that caused it, so the poison is ignored.
    fn lock(&self) -> MutexGuard<'_, State<T, R>> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
