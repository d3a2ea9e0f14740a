//! The state before a position of a recording: the hierarchy and the last lines. Its memory is bounded for
//! recordings of any length; the rest is read again.

use std::collections::{BTreeMap, VecDeque};
use std::sync::Arc;

use jde_core::Nanos;
use jde_records::RunRecord;
use jde_timeline::Timeline;

use super::index::{Index, IndexEntry};
use crate::failure::Failure;

/// Number of times at which the hierarchy is kept. Going back reads up to two of the intervals between them.
const CHECKPOINT_COUNT: Nanos = 64;
/// Number of lines kept: as many as the link keeps of all three kinds together.
const MAX_RECENT: usize = 3000;

/// The state before a position.
#[derive(Clone)]
pub(super) struct PlaybackState {
    /// The run before the first message of a time.
    checkpoints: BTreeMap<Nanos, Arc<Timeline>>,
    /// Time between two checkpoints.
    interval: Nanos,
    /// The time of the last message.
    last: Nanos,
    timeline: Timeline,
    recent: VecDeque<(Nanos, RunRecord)>,
}

impl PlaybackState {
    /// Returns the state at the beginning.
    pub(super) fn new(index: &Index) -> Self {
        Self {
            checkpoints: BTreeMap::from([(0, Arc::new(index.initial.clone()))]),
            interval: (index.end / CHECKPOINT_COUNT).max(1),
            last: 0,
            timeline: index.initial.clone(),
            recent: VecDeque::new(),
        }
    }

    /// Returns the run so far.
    pub(super) fn timeline(&self) -> &Timeline {
        &self.timeline
    }

    /// Returns the last lines, newest first.
    pub(super) fn recent(&self) -> impl Iterator<Item = &RunRecord> {
        self.recent.iter().rev().map(|(_, line)| line)
    }

    /// Applies the next entry.
    pub(super) fn apply(&mut self, next: &IndexEntry) {
        let time = next.time();
        if time / self.interval > self.last / self.interval {
            self.checkpoints
                .entry(time)
                .or_insert_with(|| Arc::new(self.timeline.clone()));
        }
        self.last = self.last.max(time);
        match next {
            IndexEntry::Value(_) => {}
            IndexEntry::Line(_, line) => {
                self.timeline.add(line);
                if self.recent.len() == MAX_RECENT {
                    self.recent.pop_front();
                }
                self.recent.push_back((time, line.clone()));
            }
            IndexEntry::Cycle(cycle) if cycle.iterated => self.timeline.add_iteration(cycle.schema),
            IndexEntry::Cycle(_) => {}
        }
    }

    /// Moves to a position. Returns the last lines from `since` to that position.
    ///
    /// # Errors
    /// The recording cannot be read.
    pub(super) fn seek(
        &mut self,
        index: &Index,
        position: Nanos,
        since: Nanos,
    ) -> Result<Vec<RunRecord>, Failure> {
        // Start at the checkpoint before the nearest one, so that some lines before any position are known.
        let mut before = self.checkpoints.range(..=position.min(since)).rev();
        let nearest = before.next();
        let Some((&from, checkpoint)) = before.next().or(nearest) else {
            return Ok(Vec::new());
        };
        self.timeline = Timeline::clone(checkpoint);
        self.last = from;
        self.recent.clear();
        for next in index
            .entries_from(from)?
            .take_while(|next| next.time() < position)
        {
            self.apply(&next);
        }
        let passed = self.recent.iter().filter(|(time, _)| *time >= since);
        Ok(passed.map(|(_, line)| line.clone()).collect())
    }

    #[cfg(test)]
    fn in_memory(&self) -> (usize, usize) {
        (self.checkpoints.len(), self.recent.len())
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use jde_records::RecordKind;
    use mcap::records::MessageHeader;

    use super::*;

    /// A recording of a schema that is woken and put to sleep in turn, a hundred times per second.
    fn recording(file: &Path, lines: u64) -> Index {
        let mut writer = mcap::WriteOptions::new()
            .chunk_size(Some(1 << 16))
            .create(std::fs::File::create(file).unwrap())
            .unwrap();
        let channel_id = writer
            .add_channel(0, RecordKind::State.topic(), "json", &BTreeMap::new())
            .unwrap();
        for number in 0..lines {
            let (from, to) = if number % 2 == 0 {
                ("slept", "winner")
            } else {
                ("winner", "slept")
            };
            let time_s = number as f64 / 100.0;
            let line = serde_json::json!({ "time_s": time_s, "schema": "goon", "from": from, "to": to });
            let header = MessageHeader {
                channel_id,
                sequence: u32::try_from(number).unwrap(),
                log_time: number * 10_000_000,
                publish_time: number * 10_000_000,
            };
            let text = serde_json::to_vec(&line).unwrap();
            assert!(RunRecord::parse(RecordKind::State, &text).is_ok());
            writer.write_to_known_channel(&header, &text).unwrap();
        }
        writer.finish().unwrap();
        drop(writer);
        Index::read(file).unwrap_or_else(|failure| panic!("{failure}"))
    }

    #[test]
    fn every_state_of_a_long_recording_is_found_in_bounded_memory() {
        let folder = tempfile::tempdir().unwrap();
        let index = recording(&folder.path().join("long.mcap"), 20_000);
        let mut playback = PlaybackState::new(&index);
        let schema_state = |playback: &PlaybackState| playback.timeline().schemas()[0].state();
        // Forward and back again: the state does not depend on the direction.
        for number in [20_000, 3, 19_999, 12_346, 12_345, 12_344, 0, 7_000] {
            let position = number * 10_000_000;
            let passed = playback
                .seek(&index, position, position.saturating_sub(50_000_000))
                .unwrap();
            assert_eq!(passed.len() as u64, number.min(5), "{number}");
            let asleep = number % 2 == 0;
            assert_eq!(
                schema_state(&playback) == jde_core::State::Slept,
                asleep,
                "{number}"
            );
            let newest = playback.recent().next().map(RunRecord::time);
            assert_eq!(newest, number.checked_sub(1).map(|last| last * 10_000_000));
            let (checkpoints, recent) = playback.in_memory();
            assert!(checkpoints as u64 <= CHECKPOINT_COUNT + 1 && recent <= MAX_RECENT);
        }
    }
}
