//! Repeats of a message that stays the newest. Zenoh drops messages on a busy connection and reports nothing,
//! so a value that does not change would never reach a client that lost it. Clients ignore what they have.

use std::time::{Duration, Instant};

/// When the first repeat is due.
const FIRST_REPEAT: Duration = Duration::from_secs(1);
/// The longest time between repeats: a static picture costs no more than this.
const LONGEST_REPEAT: Duration = Duration::from_secs(16);

/// The repeats of one publication: less often as time passes.
pub(super) struct Repeats {
    gap: Duration,
    due: Option<Instant>,
}

impl Repeats {
    pub(super) fn new() -> Self {
        Self {
            gap: FIRST_REPEAT,
            due: None,
        }
    }

    /// Starts again, after a new message.
    pub(super) fn restart(&mut self, now: Instant) {
        (self.gap, self.due) = (FIRST_REPEAT, Some(now + FIRST_REPEAT));
    }

    /// Returns whether a repeat is due, and schedules the next.
    pub(super) fn take_due(&mut self, now: Instant) -> bool {
        let is_due = self.due.is_some_and(|due| due <= now);
        if is_due {
            self.gap = LONGEST_REPEAT.min(self.gap * 2);
            self.due = Some(now + self.gap);
        }
        is_due
    }

    /// When the next repeat is due; none before the first message.
    pub(super) fn due(&self) -> Option<Instant> {
        self.due
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn repeats_become_rarer_until_a_new_message() {
        let start = Instant::now();
        let at = |seconds| start + Duration::from_secs(seconds);
        let mut repeats = Repeats::new();
        assert!(!repeats.take_due(at(100)), "no message to repeat");
        repeats.restart(start);
        let due: Vec<u64> = (0..80).filter(|second| repeats.take_due(at(*second))).collect();
        assert_eq!(due, [1, 3, 7, 15, 31, 47, 63, 79]);
        repeats.restart(at(80));
        assert_eq!(repeats.due(), Some(at(81)));
    }
}
