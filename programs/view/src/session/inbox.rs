//! What the link's threads received since the last frame. It is bounded, and counts the lines that it
//! discards.

use std::collections::VecDeque;

use jde_records::RunRecord;
use jde_records::snapshot::Snapshot;

/// Maximum number of lines that wait for a frame. While the window is hidden, the newest are kept.
const MAX_WAITING_LINES: usize = 50_000;

/// The data received since the last frame.
#[derive(Default)]
pub(super) struct Inbox {
    /// The newest snapshot.
    pub(super) snapshot: Option<Snapshot>,
    /// Lines, each with the number of lines lost before it.
    pub(super) lines: VecDeque<(RunRecord, u64)>,
    /// Number of discarded lines, plus the lines lost before each of them.
    pub(super) dropped: u64,
}

impl Inbox {
    pub(super) fn push(&mut self, line: RunRecord, missed: u64) {
        if self.lines.len() == MAX_WAITING_LINES
            && let Some((_, missed)) = self.lines.pop_front()
        {
            self.dropped += 1 + missed;
        }
        self.lines.push_back((line, missed));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn discarded_lines_are_counted_with_the_lines_lost_before_them() {
        let mut inbox = Inbox::default();
        for number in 0..MAX_WAITING_LINES as u64 + 3 {
            inbox.push(RunRecord::retracted(0, "goon.command"), number);
        }
        // 0, 1 and 2 lines were lost before the first three.
        assert_eq!((inbox.lines.len(), inbox.dropped), (MAX_WAITING_LINES, 3 + 1 + 2));
    }
}
