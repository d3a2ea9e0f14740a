//! The newest records of a run, by kind. Each has the number of its arrival, so that a reader knows what is new.

use std::collections::VecDeque;

use jde_records::{Decision, RecordKind, RunRecord};

/// Records, each with the number of its arrival, from 1.
type Numbered = VecDeque<(u64, RunRecord)>;

/// The newest records.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RecordLog {
    kinds: [Numbered; RecordKind::ALL.len()],
    /// Selections that changed the choice, older than the other kept selections.
    older: Numbered,
    limits: LogLimits,
    /// The numbers of the kept selections that changed the choice.
    switches: VecDeque<u64>,
    /// The candidates in the newest selections, and in the older ones.
    candidates: usize,
    older_candidates: usize,
    received: u64,
}

/// How much a log keeps.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LogLimits {
    /// The most records of each kind.
    pub records: usize,
    /// The most candidates in all selections: those of a group of hundreds would otherwise fill the memory.
    pub candidates: usize,
    /// The most selections that changed the choice which are kept when the selections around them are not, with as many
    /// candidates. Most selections change nothing.
    pub switches: usize,
}

impl RecordLog {
    /// Creates an empty log.
    #[must_use]
    pub fn new(limits: LogLimits) -> Self {
        Self {
            limits,
            ..Self::default()
        }
    }

    /// Adds a record. Returns how many older ones are kept no more.
    pub fn add(&mut self, record: RunRecord) -> u64 {
        self.received += 1;
        let kind = record.kind();
        self.candidates += candidates(&record);
        if let Some(decision) = decision(&record).filter(|decision| decision.changed) {
            let place = self.switches.partition_point(|number| *number < decision.number);
            self.switches.insert(place, decision.number);
        }
        let kept = &mut self.kinds[kind as usize];
        kept.push_back((self.received, record));
        sort_last(kept);
        let mut dropped = 0;
        let is_full = |kept: &Numbered, candidates| {
            kept.len() > self.limits.records
                || kind == RecordKind::Decision && candidates > self.limits.candidates
        };
        while is_full(kept, self.candidates)
            && let Some((number, oldest)) = kept.pop_front()
        {
            self.candidates -= candidates(&oldest);
            match decision(&oldest).is_some_and(|decision| decision.changed) {
                true => {
                    self.older_candidates += candidates(&oldest);
                    self.older.push_back((number, oldest));
                }
                false => dropped += 1,
            }
        }
        while self.older.len() > self.limits.switches || self.older_candidates > self.limits.candidates {
            dropped += u64::from(self.pop_older().is_some());
        }
        dropped
    }

    fn pop_older(&mut self) -> Option<RunRecord> {
        let (_, oldest) = self.older.pop_front()?;
        self.older_candidates -= candidates(&oldest);
        self.switches.pop_front();
        Some(oldest)
    }

    /// Returns the newest records of a kind, oldest first.
    pub fn of(&self, kind: RecordKind) -> impl DoubleEndedIterator<Item = &RunRecord> + ExactSizeIterator {
        self.kinds[kind as usize].iter().map(|(_, record)| record)
    }

    /// Removes the oldest record and returns it.
    pub fn pop(&mut self) -> Option<RunRecord> {
        if let Some(oldest) = self.pop_older() {
            return Some(oldest);
        }
        let arrival = |kept: &&mut Numbered| kept.front().map_or(u64::MAX, |(number, _)| *number);
        let (_, record) = self.kinds.iter_mut().min_by_key(arrival)?.pop_front()?;
        self.candidates -= candidates(&record);
        if decision(&record).map(|decision| &decision.number) == self.switches.front() {
            self.switches.pop_front();
        }
        Some(record)
    }

    /// Returns the selections, oldest first.
    #[must_use]
    pub fn decisions(&self) -> Decisions<'_> {
        Decisions {
            older: &self.older,
            newest: &self.kinds[RecordKind::Decision as usize],
        }
    }

    /// Returns the numbers of the kept selections that changed the choice, oldest first.
    #[must_use]
    pub fn switches(&self) -> &VecDeque<u64> {
        &self.switches
    }

    /// Returns how many records have arrived.
    #[must_use]
    pub fn received(&self) -> u64 {
        self.received
    }

    /// Returns the kept records that arrived after the first so many, in the order of their times.
    #[must_use]
    pub fn since(&self, received: u64) -> Vec<RunRecord> {
        let newer = self.kinds.iter().chain([&self.older]).flat_map(|kept| {
            let first = kept.partition_point(|(number, _)| *number <= received);
            kept.range(first..)
        });
        let mut newer: Vec<_> = newer.cloned().collect();
        newer.sort_by_key(|(number, record)| (record.time(), *number));
        newer.into_iter().map(|(_, record)| record).collect()
    }

    /// Removes the records that are later than a time.
    pub(crate) fn rewind(&mut self, now: jde_core::Nanos) {
        for kept in self.kinds.iter_mut().chain([&mut self.older]) {
            kept.retain(|(_, record)| record.time() <= now);
        }
        let newest = &self.kinds[RecordKind::Decision as usize];
        let sum = |kept: &Numbered| kept.iter().map(|(_, record)| candidates(record)).sum();
        (self.older_candidates, self.candidates) = (sum(&self.older), sum(newest));
        let kept = self.older.iter().chain(newest);
        let kept = kept.filter_map(|(_, record)| decision(record));
        let switches = kept.filter(|decision| decision.changed);
        self.switches = switches.map(|decision| decision.number).collect();
    }
}

/// Selections, oldest first. Of the older ones, only those that changed the choice are there.
#[derive(Clone, Copy, Debug)]
pub struct Decisions<'l> {
    older: &'l Numbered,
    newest: &'l Numbered,
}

impl<'l> Decisions<'l> {
    /// Returns how many there are.
    #[must_use]
    pub fn len(self) -> usize {
        self.older.len() + self.newest.len()
    }

    /// Returns whether there is none.
    #[must_use]
    pub fn is_empty(self) -> bool {
        self.len() == 0
    }

    /// Returns the selection at a place.
    #[must_use]
    pub fn get(self, place: usize) -> Option<&'l Decision> {
        let kept = match place.checked_sub(self.older.len()) {
            Some(place) => self.newest.get(place),
            None => self.older.get(place),
        };
        decision(&kept?.1)
    }

    /// Returns the number of the first selections for which a condition holds. It holds for none after one for which it does
    /// not hold.
    #[must_use]
    pub fn partition_point(self, holds: impl Fn(&Decision) -> bool) -> usize {
        let holds = |kept: &(u64, RunRecord)| decision(&kept.1).is_some_and(&holds);
        match self.older.partition_point(holds) {
            all if all == self.older.len() => all + self.newest.partition_point(holds),
            place => place,
        }
    }

    /// Returns the selection that has a number in the run.
    #[must_use]
    pub fn find(self, number: u64) -> Option<&'l Decision> {
        let found = self.get(self.partition_point(|decision| decision.number < number))?;
        (found.number == number).then_some(found)
    }
}

/// Puts the newest selection in its place. It arrives when its takeover is known, which may be after a later selection.
fn sort_last(kept: &mut Numbered) {
    let number = |kept: &Numbered, place: usize| decision(&kept[place].1).map(|decision| decision.number);
    let mut place = kept.len() - 1;
    while place > 0 && number(kept, place - 1) > number(kept, place) {
        kept.swap(place - 1, place);
        // The order of arrival stays.
        let arrival = kept[place].0;
        kept[place].0 = std::mem::replace(&mut kept[place - 1].0, arrival);
        place -= 1;
    }
}

fn decision(record: &RunRecord) -> Option<&Decision> {
    match record {
        RunRecord::Decision(decision) => Some(decision),
        RunRecord::State(_) | RunRecord::Other(_) => None,
    }
}

fn candidates(record: &RunRecord) -> usize {
    decision(record).map_or(0, |decision| decision.candidates.len())
}
