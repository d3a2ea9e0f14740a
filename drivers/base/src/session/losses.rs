//! The lines that were lost on the way, and what is said of them.

use core::time::Duration;

/// Time between two warnings.
const PAUSE: Duration = Duration::from_secs(10);

/// Counts of one session.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Losses {
    /// Lines of the board's state that did not arrive, by their numbers.
    pub(super) missing: u64,
    /// Lines with wrong checksums, or of no sense.
    pub(super) corrupt: u64,
    /// Lines that the board refused.
    pub(super) refused: u64,
}

/// Keeps a warning from being said too often.
#[derive(Debug, Default)]
pub(super) struct Throttle {
    next: Duration,
}

impl Throttle {
    /// Whether it is time to say it, and then not for a while.
    pub(super) fn is_time(&mut self, now: Duration) -> bool {
        let is_time = now >= self.next;
        if is_time {
            self.next = now + PAUSE;
        }
        is_time
    }
}

/// Says the losses.
#[derive(Debug, Default)]
pub(super) struct Warnings {
    said: Losses,
    throttle: Throttle,
}

impl Warnings {
    /// Returns what to say of these losses, if it is new and time.
    pub(super) fn update(&mut self, losses: Losses, now: Duration) -> Option<String> {
        if losses == self.said || !self.throttle.is_time(now) {
            return None;
        }
        self.said = losses;
        let Losses {
            missing,
            corrupt,
            refused,
        } = losses;
        Some(format!(
            "lost so far: {missing} lines of the board, {corrupt} with wrong checksums, {refused} that it refused; is the \
             cable near a motor's, or its ground missing?"
        ))
    }
}
