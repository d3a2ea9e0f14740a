//! A bounded queue between a thread that must not wait and one that may. When it is full, it drops and counts
//! its oldest elements.

use std::collections::VecDeque;
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

/// A first-in-first-out queue of bounded length, for use from any thread.
pub(crate) struct Queue<T> {
    state: Mutex<State<T>>,
    changed: Condvar,
    most: usize,
}

struct State<T> {
    waiting: VecDeque<T>,
    missed: u64,
    closed: bool,
}

/// The result of taking from a queue.
#[derive(Debug, PartialEq, Eq)]
pub(crate) enum Taken<T> {
    /// The oldest element, and how many elements were dropped since the previous one was taken.
    Next { what: T, missed: u64 },
    /// The queue is empty.
    Nothing,
    /// The queue is empty and closed.
    Closed,
}

impl<T> Queue<T> {
    /// Creates a queue of at most `most` elements.
    pub(crate) fn new(most: usize) -> Arc<Self> {
        Arc::new(Self {
            state: Mutex::new(State {
                waiting: VecDeque::new(),
                missed: 0,
                closed: false,
            }),
            changed: Condvar::new(),
            most,
        })
    }

    /// Appends an element without waiting for room. A full queue drops its oldest element, a closed one
    /// ignores the new element.
    pub(crate) fn add(&self, what: T) {
        let mut state = self.lock();
        if state.closed {
            return;
        }
        if state.waiting.len() >= self.most {
            state.waiting.pop_front();
            state.missed += 1;
        }
        state.waiting.push_back(what);
        drop(state);
        self.changed.notify_one();
    }

    /// Closes the queue: it ignores further elements, and those in it can still be taken.
    pub(crate) fn close(&self) {
        self.lock().closed = true;
        self.changed.notify_all();
    }

    /// Takes the oldest element without waiting for one.
    pub(crate) fn take_now(&self) -> Taken<T> {
        self.lock().take()
    }

    /// Takes the oldest element, after waiting at most `most` for one.
    pub(crate) fn take_within(&self, most: Duration) -> Taken<T> {
        let waited = self
            .changed
            .wait_timeout_while(self.lock(), most, |state| state.waits());
        waited.unwrap_or_else(PoisonError::into_inner).0.take()
    }

    /// Waits for an element and takes the oldest, with the number dropped before it. Returns `None` once the
    /// queue is closed and empty.
    pub(crate) fn take(&self) -> Option<(T, u64)> {
        let waited = self.changed.wait_while(self.lock(), |state| state.waits());
        match waited.unwrap_or_else(PoisonError::into_inner).take() {
            Taken::Next { what, missed } => Some((what, missed)),
            Taken::Nothing | Taken::Closed => None,
        }
    }

    fn lock(&self) -> MutexGuard<'_, State<T>> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl<T> State<T> {
    fn waits(&mut self) -> bool {
        self.waiting.is_empty() && !self.closed
    }

    fn take(&mut self) -> Taken<T> {
        match self.waiting.pop_front() {
            Some(what) => Taken::Next {
                what,
                missed: std::mem::take(&mut self.missed),
            },
            None if self.closed => Taken::Closed,
            None => Taken::Nothing,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_oldest_go_and_are_counted_where_they_are_missing() {
        let queue = Queue::new(3);
        (0..10).for_each(|number| queue.add(number));
        assert_eq!(queue.take(), Some((7, 7)));
        assert_eq!(queue.take(), Some((8, 0)));
        queue.add(10);
        assert_eq!(queue.take_now(), Taken::Next { what: 9, missed: 0 });
        assert_eq!(
            queue.take_within(Duration::MAX),
            Taken::Next { what: 10, missed: 0 }
        );
        assert_eq!(queue.take_now(), Taken::Nothing);
        assert_eq!(queue.take_within(Duration::ZERO), Taken::Nothing);
    }

    #[test]
    fn what_is_there_at_the_end_is_taken_and_nothing_after_it() {
        let queue = Queue::new(3);
        queue.add(1);
        queue.close();
        queue.add(2);
        assert_eq!(queue.take(), Some((1, 0)));
        assert_eq!((queue.take(), queue.take_now()), (None, Taken::Closed));
    }
}
