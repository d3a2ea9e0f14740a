//! Values that wait for a reader that needs each of them. The backlog is bounded: it discards the oldest
//! values, and always keeps the newest.

use std::collections::VecDeque;
use std::sync::Arc;

use jde_link::Sample;

/// Maximum number of waiting values: those of 40 s at 100 Hz. Readers call more often.
const MAX_WAITING: usize = 4096;
/// Maximum size of the waiting values, in bytes: about one second of camera images.
const MOST_BYTES: usize = 16 << 20;

/// The waiting values, oldest first.
#[derive(Debug, Default)]
pub(super) struct Backlog {
    samples: VecDeque<Arc<Sample>>,
    bytes: usize,
}

impl Backlog {
    pub(super) fn push(&mut self, sample: Arc<Sample>) {
        self.bytes += size(&sample);
        self.samples.push_back(sample);
        while self.samples.len() > 1 && (self.samples.len() > MAX_WAITING || self.bytes > MOST_BYTES) {
            if let Some(oldest) = self.samples.pop_front() {
                self.bytes -= size(&oldest);
            }
        }
    }

    /// Removes and returns all values.
    pub(super) fn take(&mut self) -> Vec<Arc<Sample>> {
        self.bytes = 0;
        std::mem::take(&mut self.samples).into()
    }
}

fn size(sample: &Sample) -> usize {
    sample.bytes.as_ref().map_or(0, |bytes| bytes.len())
}

#[cfg(test)]
mod tests {
    use super::super::subscriptions::tests::sample;
    use super::*;

    #[test]
    fn of_too_many_or_too_large_values_the_newest_are_kept() {
        let mut backlog = Backlog::default();
        for number in 0..2 * MAX_WAITING as u64 {
            backlog.push(sample(number, 8));
        }
        let remaining = backlog.take();
        assert_eq!(
            (remaining.len(), remaining[0].sequence),
            (MAX_WAITING, MAX_WAITING as u64)
        );
        assert!(backlog.take().is_empty());
        for number in 0..100 {
            backlog.push(sample(number, 1 << 20));
        }
        let remaining = backlog.take();
        assert_eq!((remaining.len(), remaining[15].sequence), (16, 99));
        backlog.push(sample(1, 2 * MOST_BYTES));
        assert_eq!(backlog.take().len(), 1, "the newest is kept, however large it is");
    }
}
