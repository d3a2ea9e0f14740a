//! Events other than selections and state changes. Of many, the first and the last are stored and the rest
//! counted.

use std::collections::{BTreeMap, VecDeque};

use jde_records::EventRecord;

/// Events stored: so many of the first, and of the last.
const FIRST: usize = 1000;
const LAST: usize = 500;
/// Most kinds that are counted separately.
const MOST_KINDS: usize = 64;

/// Events in their order.
#[derive(Clone, Debug, Default)]
pub(crate) struct Events {
    first: Vec<EventRecord>,
    last: VecDeque<EventRecord>,
    /// The number of dropped events in between.
    pub(crate) left_out: u64,
    /// The number of events by kind.
    pub(crate) kinds: BTreeMap<String, u64>,
}

impl Events {
    pub(crate) fn add(&mut self, happening: EventRecord) {
        if let Some(count) = self.kinds.get_mut(&happening.kind) {
            *count += 1;
        } else if self.kinds.len() < MOST_KINDS {
            self.kinds.insert(happening.kind.clone(), 1);
        }
        if self.first.len() < FIRST {
            self.first.push(happening);
            return;
        }
        self.last.push_back(happening);
        if self.last.len() > LAST {
            self.last.pop_front();
            self.left_out += 1;
        }
    }

    /// The number of events of a kind.
    pub(crate) fn count(&self, kind: &str) -> u64 {
        self.kinds.get(kind).copied().unwrap_or(0)
    }

    /// The last stored event of a kind.
    pub(crate) fn last_of(&self, kind: &str) -> Option<&EventRecord> {
        self.kept().filter(|happening| happening.kind == kind).last()
    }

    /// The stored events.
    pub(crate) fn kept(&self) -> impl Iterator<Item = &EventRecord> {
        self.first.iter().chain(&self.last)
    }
}
