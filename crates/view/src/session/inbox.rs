//! What the link's threads left since the last frame. Bounded: whoever does not look is told how much was not kept.

use std::collections::VecDeque;

use jde_host::snapshot::Snapshot;
use jde_host::story::Line;

/// Lines that may wait for a frame; a window that is hidden keeps the newest.
const WAITING: usize = 50_000;

/// What is new.
#[derive(Default)]
pub(super) struct Inbox {
    /// The newest.
    pub(super) snapshot: Option<Snapshot>,
    /// Each with how many before it did not come.
    pub(super) lines: VecDeque<(Line, u64)>,
    /// Lines that no longer wait, although nobody has seen them, with those before them that did not come.
    pub(super) dropped: u64,
}

impl Inbox {
    pub(super) fn push(&mut self, line: Line, missed: u64) {
        if self.lines.len() == WAITING
            && let Some((_, missed)) = self.lines.pop_front()
        {
            self.dropped += 1 + missed;
        }
        self.lines.push_back((line, missed));
    }
}

#[cfg(test)]
mod tests {
    use jde_host::story::Happening;

    use super::*;

    #[test]
    fn lines_that_wait_for_too_long_are_counted_with_those_that_did_not_come() {
        let mut inbox = Inbox::default();
        for number in 0..WAITING as u64 + 3 {
            inbox.push(Line::Happening(Happening::default()), number);
        }
        // Before the first three 0, 1 and 2 did not come.
        assert_eq!((inbox.lines.len(), inbox.dropped), (WAITING, 3 + 1 + 2));
    }
}
