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

/// Says them, not too often.
#[derive(Debug, Default)]
pub(super) struct Warnings {
    said: Losses,
    next: Duration,
}

impl Warnings {
    /// Returns what to say of these losses, if it is new and time.
    pub(super) fn update(&mut self, losses: Losses, now: Duration) -> Option<String> {
        if losses == self.said || now < self.next {
            return None;
        }
        (self.said, self.next) = (losses, now + PAUSE);
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
