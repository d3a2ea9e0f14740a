//! Events other than selections and state changes. Of many, the first and the last are stored and the rest
//! counted.

use std::collections::BTreeMap;

use jde_records::EventRecord;

use super::bounded::{Ends, count};

/// Events stored: so many of the first, and of the last.
const FIRST: usize = 1000;
const LAST: usize = 500;
/// Most kinds that are counted separately.
const MOST_KINDS: usize = 64;

/// Events in their order.
#[derive(Clone, Debug)]
pub(crate) struct Events {
    pub(crate) list: Ends<EventRecord>,
    /// The number of events by kind.
    pub(crate) kinds: BTreeMap<String, u64>,
}

impl Events {
    pub(crate) fn new() -> Self {
        Self {
            list: Ends::new(FIRST, LAST),
            kinds: BTreeMap::new(),
        }
    }

    pub(crate) fn add(&mut self, happening: EventRecord) {
        count(&mut self.kinds, &happening.kind, MOST_KINDS);
        self.list.add(happening);
    }

    /// The number of events of a kind.
    pub(crate) fn count(&self, kind: &str) -> u64 {
        self.kinds.get(kind).copied().unwrap_or(0)
    }

    /// The last stored event of a kind.
    pub(crate) fn last_of(&self, kind: &str) -> Option<&EventRecord> {
        let events = self.list.kept();
        events.filter(|happening| happening.kind == kind).last()
    }
}
