//! Bounded queues for requests, served in turn, so that a client that fills its queue receives only its share
//! of the service while others have requests. Any thread may push; only one may pop.

use std::sync::atomic::{AtomicUsize, Ordering};

use crossbeam_queue::ArrayQueue;

/// The number of queues: half for each origin. If there are more clients, they share queues.
pub(super) const QUEUES: usize = 16;
/// Most requests in one queue.
const MAX_LENGTH: usize = 64;

/// The queues.
pub(super) struct FairQueue<T> {
    queues: [ArrayQueue<T>; QUEUES],
    /// The queue to serve next.
    turn: AtomicUsize,
}

impl<T> FairQueue<T> {
    pub(super) fn new() -> Self {
        Self {
            queues: std::array::from_fn(|_| ArrayQueue::new(MAX_LENGTH)),
            turn: AtomicUsize::new(0),
        }
    }

    /// Appends to a queue; returns `false` if that queue is full.
    pub(super) fn push(&self, queue: usize, item: T) -> bool {
        self.queues[queue % QUEUES].push(item).is_ok()
    }

    /// Takes the next item, from each queue in turn.
    pub(super) fn pop(&self) -> Option<T> {
        let turn = self.turn.load(Ordering::Relaxed);
        (turn..turn + QUEUES).find_map(|queue| {
            let item = self.queues[queue % QUEUES].pop()?;
            self.turn.store((queue + 1) % QUEUES, Ordering::Relaxed);
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
    fn a_full_queue_delays_no_other_queue() {
        let queues = FairQueue::new();
        let accepted = (0..1000).filter(|_| queues.push(3, "flood")).count();
        assert_eq!(accepted, MAX_LENGTH);
        assert!(queues.push(4, "other"), "the queue of another client is not full");
        assert!(queues.push(15, "network"));
        let served: Vec<_> = std::iter::from_fn(|| queues.pop()).take(3).collect();
        assert_eq!(served, ["flood", "other", "network"]);
        for _ in 0..5 {
            assert_eq!(queues.pop(), Some("flood"));
        }
        // The other queue is served next, before the rest of the full one.
        assert!(queues.push(2, "late"));
        assert_eq!(queues.pop(), Some("late"));
        assert_eq!(std::iter::from_fn(|| queues.pop()).count(), MAX_LENGTH - 6);
        assert!(queues.is_empty());
    }
}
