//! What was before a place of a recording: how the hierarchy stood, and what was told last. Of a recording of any length a bounded part
//! is in memory; the rest is read again.

use std::collections::{BTreeMap, VecDeque};
use std::sync::Arc;

use jde_core::Nanos;
use jde_host::story::Line;

use super::cast::Hierarchy;
use super::index::{Index, Next};
use crate::failure::Failure;

/// Places at which the hierarchy is kept: to go back takes reading two parts in so many of the recording.
const MARKS: Nanos = 64;
/// Lines that are kept: as many of a kind as the link keeps of what was passed over.
const RECENT: usize = 3000;

/// What was before a place.
#[derive(Clone)]
pub(super) struct Past {
    /// How the hierarchy stood before the first message of a time.
    marks: BTreeMap<Nanos, Arc<Hierarchy>>,
    /// Time between two marks.
    every: Nanos,
    /// When the last message was.
    last: Nanos,
    now: Hierarchy,
    recent: VecDeque<(Nanos, Line)>,
}

impl Past {
    /// Of the beginning.
    pub(super) fn new(index: &Index) -> Self {
        Self {
            marks: BTreeMap::from([(0, Arc::new(index.blank.clone()))]),
            every: (index.end / MARKS).max(1),
            last: 0,
            now: index.blank.clone(),
            recent: VecDeque::new(),
        }
    }

    /// The hierarchy.
    pub(super) fn hierarchy(&self) -> &Hierarchy {
        &self.now
    }

    /// What was told last, the newest first.
    pub(super) fn recent(&self) -> impl Iterator<Item = &Line> {
        self.recent.iter().rev().map(|(_, line)| line)
    }

    /// Takes in what comes next.
    pub(super) fn take_in(&mut self, next: &Next) {
        let time = next.time();
        if time / self.every > self.last / self.every {
            self.marks
                .entry(time)
                .or_insert_with(|| Arc::new(self.now.clone()));
        }
        self.last = self.last.max(time);
        match next {
            Next::Value(_) => {}
            Next::Line(_, line) => {
                self.now.hear(line);
                if self.recent.len() == RECENT {
                    self.recent.pop_front();
                }
                self.recent.push_back((time, line.clone()));
            }
            Next::Cycle(cycle) => self.now.cycle(cycle),
        }
    }

    /// Goes to a place; answers with the last lines that were told from `since` until there.
    ///
    /// # Errors
    /// The recording cannot be read.
    pub(super) fn go_to(&mut self, index: &Index, place: Nanos, since: Nanos) -> Result<Vec<Line>, Failure> {
        // From the mark before the nearest, so that something of what was told before is known wherever one goes.
        let mut before = self.marks.range(..=place.min(since)).rev();
        let nearest = before.next();
        let Some((&from, mark)) = before.next().or(nearest) else {
            return Ok(Vec::new());
        };
        self.now = Hierarchy::clone(mark);
        self.last = from;
        self.recent.clear();
        for next in index.from(from)?.take_while(|next| next.time() < place) {
            self.take_in(&next);
        }
        let passed = self.recent.iter().filter(|(time, _)| *time >= since);
        Ok(passed.map(|(_, line)| line.clone()).collect())
    }

    #[cfg(test)]
    fn in_memory(&self) -> (usize, usize) {
        (self.marks.len(), self.recent.len())
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use jde_host::story::Kind;
    use mcap::records::MessageHeader;

    use super::*;

    /// A recording of a schema that is woken and put to sleep in turn, a hundred times a second.
    fn recording(file: &Path, lines: u64) -> Index {
        let mut writer = mcap::WriteOptions::new()
            .chunk_size(Some(1 << 16))
            .create(std::fs::File::create(file).unwrap())
            .unwrap();
        let channel_id = writer
            .add_channel(0, Kind::Change.topic(), "json", &BTreeMap::new())
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
            assert!(Line::read(Kind::Change, &text).is_ok());
            writer.write_to_known_channel(&header, &text).unwrap();
        }
        writer.finish().unwrap();
        drop(writer);
        Index::read(file).unwrap_or_else(|failure| panic!("{failure}"))
    }

    #[test]
    fn a_long_recording_is_known_everywhere_and_only_a_part_of_it_in_memory() {
        let folder = tempfile::tempdir().unwrap();
        let index = recording(&folder.path().join("long.mcap"), 20_000);
        let mut past = Past::new(&index);
        let state = |past: &Past, place| past.hierarchy().snapshot(place).schemas[0].state;
        // There and back again: the same wherever one comes from.
        for number in [20_000, 3, 19_999, 12_346, 12_345, 12_344, 0, 7_000] {
            let place = number * 10_000_000;
            let told = past
                .go_to(&index, place, place.saturating_sub(50_000_000))
                .unwrap();
            assert_eq!(told.len() as u64, number.min(5), "{number}");
            let asleep = number % 2 == 0;
            assert_eq!(state(&past, place) == jde_core::State::Slept, asleep, "{number}");
            let newest = past.recent().next().map(Line::time);
            assert_eq!(newest, number.checked_sub(1).map(|last| last * 10_000_000));
            let (marks, recent) = past.in_memory();
            assert!(marks as u64 <= MARKS + 1 && recent <= RECENT);
        }
    }
}
