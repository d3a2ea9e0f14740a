//! Bounded queues for requests, served in turn, so that a client that fills one gets only its share while
//! others have requests. Any thread may push; only one may pop.

use std::sync::atomic::{AtomicUsize, Ordering};

use crossbeam_queue::ArrayQueue;

/// The number of lines: half for each origin. More clients than lines share them.
pub(super) const QUEUES: usize = 16;
/// Most requests in one line.
const MAX_LENGTH: usize = 64;

/// The queues.
pub(super) struct FairQueue<T> {
    queues: [ArrayQueue<T>; QUEUES],
    /// The line to serve next.
    turn: AtomicUsize,
}

impl<T> FairQueue<T> {
    pub(super) fn new() -> Self {
        Self {
            queues: std::array::from_fn(|_| ArrayQueue::new(MAX_LENGTH)),
            turn: AtomicUsize::new(0),
        }
    }

    /// Appends to a line; returns `false` if the line is full.
    pub(super) fn push(&self, line: usize, item: T) -> bool {
        self.queues[line % QUEUES].push(item).is_ok()
    }

    /// Takes the next item, from each line in turn.
    pub(super) fn pop(&self) -> Option<T> {
        let turn = self.turn.load(Ordering::Relaxed);
        (turn..turn + QUEUES).find_map(|line| {
            let item = self.queues[line % QUEUES].pop()?;
            self.turn.store((line + 1) % QUEUES, Ordering::Relaxed);
            Some(item)
        })
    }

    pub(super) fn is_empty(&self) -> bool {
        self.queues.iter().all(ArrayQueue::is_empty)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn whoever_asks_much_waits_for_himself_and_others_do_not() {
        let lines = FairQueue::new();
        let put = (0..1000).filter(|_| lines.push(3, "flood")).count();
        assert_eq!(put, MAX_LENGTH);
        assert!(lines.push(4, "other"), "its line is not full");
        assert!(lines.push(15, "network"));
        let served: Vec<_> = std::iter::from_fn(|| lines.pop()).take(3).collect();
        assert_eq!(served, ["flood", "other", "network"]);
        for _ in 0..5 {
            assert_eq!(lines.pop(), Some("flood"));
        }
        // The other line is served next, before the rest of the full one.
        assert!(lines.push(2, "late"));
        assert_eq!(lines.pop(), Some("late"));
        assert_eq!(std::iter::from_fn(|| lines.pop()).count(), MAX_LENGTH - 6);
        assert!(lines.is_empty());
    }
}
