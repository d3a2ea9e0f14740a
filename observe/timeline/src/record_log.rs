//! The newest records of a run, by kind. Each has the number of its arrival, so that a reader knows what is new.

use std::collections::VecDeque;

use jde_records::{Decision, RecordKind, RunRecord};

/// Records, each with the number of its arrival, from 1.
type Numbered = VecDeque<(u64, RunRecord)>;

/// The newest records.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RecordLog {
    kinds: [Numbered; RecordKind::ALL.len()],
    limits: LogLimits,
    /// The numbers of the kept selections that changed the choice.
    switches: VecDeque<u64>,
    /// The candidates in all kept selections.
    candidates: usize,
    received: u64,
}

/// How much a log keeps.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LogLimits {
    /// The most records of each kind.
    pub records: usize,
    /// The most candidates in all selections: those of a group of hundreds would otherwise fill the memory.
    pub candidates: usize,
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
            self.switches.push_back(decision.number);
        }
        let kept = &mut self.kinds[kind as usize];
        kept.push_back((self.received, record));
        let mut dropped = 0;
        let is_full = |kept: &Numbered, candidates| {
            kept.len() > self.limits.records
                || kind == RecordKind::Decision && candidates > self.limits.candidates
        };
        while is_full(kept, self.candidates)
            && let Some((_, oldest)) = kept.pop_front()
        {
            self.candidates -= candidates(&oldest);
            if decision(&oldest).map(|decision| &decision.number) == self.switches.front() {
                self.switches.pop_front();
            }
            dropped += 1;
        }
        dropped
    }

    /// Returns the records of a kind, oldest first.
    pub fn of(&self, kind: RecordKind) -> impl DoubleEndedIterator<Item = &RunRecord> + ExactSizeIterator {
        self.kinds[kind as usize].iter().map(|(_, record)| record)
    }

    /// Removes the oldest record and returns it.
    pub fn pop(&mut self) -> Option<RunRecord> {
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
        Decisions(&self.kinds[RecordKind::Decision as usize])
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
        let newer = self.kinds.iter().flat_map(|kept| {
            let first = kept.partition_point(|(number, _)| *number <= received);
            kept.range(first..)
        });
        let mut newer: Vec<_> = newer.cloned().collect();
        newer.sort_by_key(|(number, record)| (record.time(), *number));
        newer.into_iter().map(|(_, record)| record).collect()
    }

    /// Removes the records that are later than a time.
    pub(crate) fn rewind(&mut self, now: jde_core::Nanos) {
        for kept in &mut self.kinds {
            kept.retain(|(_, record)| record.time() <= now);
        }
        let kept = self.kinds[RecordKind::Decision as usize].iter();
        let kept = kept.filter_map(|(_, record)| decision(record));
        self.candidates = kept.clone().map(|decision| decision.candidates.len()).sum();
        let switches = kept.filter(|decision| decision.changed);
        self.switches = switches.map(|decision| decision.number).collect();
    }
}

/// Selections, oldest first.
#[derive(Clone, Copy, Debug)]
pub struct Decisions<'l>(&'l Numbered);

impl<'l> Decisions<'l> {
    /// Returns how many there are.
    #[must_use]
    pub fn len(self) -> usize {
        self.0.len()
    }

    /// Returns whether there is none.
    #[must_use]
    pub fn is_empty(self) -> bool {
        self.0.is_empty()
    }

    /// Returns the selection at a place.
    #[must_use]
    pub fn get(self, place: usize) -> Option<&'l Decision> {
        decision(&self.0.get(place)?.1)
    }

    /// Returns the number of the first selections for which a condition holds. It holds for none after one for which it does
    /// not hold.
    #[must_use]
    pub fn partition_point(self, holds: impl Fn(&Decision) -> bool) -> usize {
        self.0
            .partition_point(|(_, record)| decision(record).is_some_and(&holds))
    }

    /// Returns the selection that has a number in the run.
    #[must_use]
    pub fn find(self, number: u64) -> Option<&'l Decision> {
        let found = self.get(self.partition_point(|decision| decision.number < number))?;
        (found.number == number).then_some(found)
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
