//! Lines in which requests wait: bounded each for itself, and served in turn, so that whoever fills one gets no more than a share while
//! others ask. Any thread may put something in; one alone takes things out.

use std::sync::atomic::{AtomicUsize, Ordering};

use crossbeam_queue::ArrayQueue;

/// How many: half of them for each origin. Clients beyond that share.
pub(super) const LINES: usize = 16;
/// Requests that wait in one.
const LONGEST: usize = 64;

/// Requests that wait.
pub(super) struct Lines<T> {
    lines: [ArrayQueue<T>; LINES],
    /// Whose turn it is.
    turn: AtomicUsize,
}

impl<T> Lines<T> {
    pub(super) fn new() -> Self {
        Self {
            lines: std::array::from_fn(|_| ArrayQueue::new(LONGEST)),
            turn: AtomicUsize::new(0),
        }
    }

    /// Puts something at the end of a line; not if that is full.
    pub(super) fn push(&self, line: usize, item: T) -> bool {
        self.lines[line % LINES].push(item).is_ok()
    }

    /// Takes what is next, of each line in turn.
    pub(super) fn pop(&self) -> Option<T> {
        let turn = self.turn.load(Ordering::Relaxed);
        (turn..turn + LINES).find_map(|line| {
            let item = self.lines[line % LINES].pop()?;
            self.turn.store((line + 1) % LINES, Ordering::Relaxed);
            Some(item)
        })
    }

    pub(super) fn is_empty(&self) -> bool {
        self.lines.iter().all(ArrayQueue::is_empty)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn whoever_asks_much_waits_for_himself_and_others_do_not() {
        let lines = Lines::new();
        let put = (0..1000).filter(|_| lines.push(3, "flood")).count();
        assert_eq!(put, LONGEST);
        assert!(lines.push(4, "other"), "its line is not full");
        assert!(lines.push(15, "network"));
        let served: Vec<_> = std::iter::from_fn(|| lines.pop()).take(3).collect();
        assert_eq!(served, ["flood", "other", "network"]);
        for _ in 0..5 {
            assert_eq!(lines.pop(), Some("flood"));
        }
        // The line before is served next, not after all that is in the other.
        assert!(lines.push(2, "late"));
        assert_eq!(lines.pop(), Some("late"));
        assert_eq!(std::iter::from_fn(|| lines.pop()).count(), LONGEST - 6);
        assert!(lines.is_empty());
    }
}
