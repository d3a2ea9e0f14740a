//! A bounded queue between a thread that must not wait and one that may. When it is full, it drops and counts
//! its oldest elements.

use std::collections::VecDeque;
use std::sync::Arc;
use std::time::Duration;

use parking_lot::{Condvar, Mutex};

/// A first-in-first-out queue of bounded length, for use from any thread.
pub struct Queue<T> {
    state: Mutex<QueueState<T>>,
    changed: Condvar,
    capacity: usize,
}

struct QueueState<T> {
    items: VecDeque<T>,
    dropped: u64,
    closed: bool,
}

/// The result of taking from a queue.
#[derive(Debug, PartialEq, Eq)]
pub enum Popped<T> {
    /// The oldest element, and how many elements were dropped since the previous one was taken.
    Next {
        /// The element.
        item: T,
        /// The number.
        dropped: u64,
    },
    /// The queue is empty.
    Empty,
    /// The queue is empty and closed.
    Closed,
}

impl<T> Queue<T> {
    /// Creates a queue of at most `capacity` elements.
    pub fn new(capacity: usize) -> Arc<Self> {
        Arc::new(Self {
            state: Mutex::new(QueueState {
                items: VecDeque::new(),
                dropped: 0,
                closed: false,
            }),
            changed: Condvar::new(),
            capacity,
        })
    }

    /// Appends an element without waiting for room. A full queue drops its oldest element, a closed one
    /// ignores the new element.
    pub fn push(&self, item: T) {
        let mut state = self.state.lock();
        if state.closed {
            return;
        }
        if state.items.len() >= self.capacity {
            state.items.pop_front();
            state.dropped += 1;
        }
        state.items.push_back(item);
        drop(state);
        self.changed.notify_one();
    }

    /// Closes the queue: it ignores further elements, and those in it can still be taken.
    pub fn close(&self) {
        self.state.lock().closed = true;
        self.changed.notify_all();
    }

    /// Takes the oldest element without waiting for one.
    pub fn try_pop(&self) -> Popped<T> {
        self.state.lock().pop()
    }

    /// Takes the oldest element, after waiting at most `timeout` for one.
    pub fn pop_timeout(&self, timeout: Duration) -> Popped<T> {
        let mut state = self.state.lock();
        self.changed
            .wait_while_for(&mut state, |state| state.is_empty_and_open(), timeout);
        state.pop()
    }

    /// Waits for an element and takes the oldest, with the number dropped before it. Returns `None` once the
    /// queue is closed and empty.
    pub fn pop(&self) -> Option<(T, u64)> {
        let mut state = self.state.lock();
        self.changed
            .wait_while(&mut state, |state| state.is_empty_and_open());
        match state.pop() {
            Popped::Next { item, dropped } => Some((item, dropped)),
            Popped::Empty | Popped::Closed => None,
        }
    }
}

impl<T> QueueState<T> {
    fn is_empty_and_open(&mut self) -> bool {
        self.items.is_empty() && !self.closed
    }

    fn pop(&mut self) -> Popped<T> {
        match self.items.pop_front() {
            Some(item) => Popped::Next {
                item,
                dropped: std::mem::take(&mut self.dropped),
            },
            None if self.closed => Popped::Closed,
            None => Popped::Empty,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_full_queue_drops_and_counts_its_oldest_elements() {
        let queue = Queue::new(3);
        (0..10).for_each(|number| queue.push(number));
        assert_eq!(queue.pop(), Some((7, 7)));
        assert_eq!(queue.pop(), Some((8, 0)));
        queue.push(10);
        assert_eq!(queue.try_pop(), Popped::Next { item: 9, dropped: 0 });
        assert_eq!(
            queue.pop_timeout(Duration::MAX),
            Popped::Next { item: 10, dropped: 0 }
        );
        assert_eq!(queue.try_pop(), Popped::Empty);
        assert_eq!(queue.pop_timeout(Duration::ZERO), Popped::Empty);
    }

    #[test]
    fn elements_before_the_close_are_taken_and_later_ones_ignored() {
        let queue = Queue::new(3);
        queue.push(1);
        queue.close();
        queue.push(2);
        assert_eq!(queue.pop(), Some((1, 0)));
        assert_eq!((queue.pop(), queue.try_pop()), (None, Popped::Closed));
    }
}
