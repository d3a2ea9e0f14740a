//! Events other than selections and state changes. Of many, the first and the last are stored and the rest
//! counted.

use std::collections::BTreeMap;

use jde_core::Health;
use jde_records::event::{Occurrence, What};
use jde_timeline::MarkKind;

use super::bounded::{Ends, count};

/// Events stored: so many of the first, and of the last.
const FIRST_EVENTS: usize = 1000;
const LAST_EVENTS: usize = 500;
/// Most kinds that are counted separately.
const MOST_KINDS: usize = 64;

/// Events in their order.
#[derive(Clone, Debug)]
pub(crate) struct Events {
    pub(crate) list: Ends<Occurrence<String>>,
    /// The number of events by kind.
    pub(crate) kinds: BTreeMap<String, u64>,
    /// The number of actions of operators.
    pub(crate) operations: u64,
}

impl Events {
    pub(crate) fn new() -> Self {
        Self {
            list: Ends::new(FIRST_EVENTS, LAST_EVENTS),
            kinds: BTreeMap::new(),
            operations: 0,
        }
    }

    pub(crate) fn add(&mut self, event: Occurrence<String>) {
        // A missed deadline is an overrun and a change of health, and one of the two is counted.
        let is_counted = !matches!(
            &event.what,
            What::HealthChanged {
                health: Health::Overrun,
                ..
            }
        );
        if is_counted {
            count(&mut self.kinds, &event.what.kind().to_owned(), MOST_KINDS);
        }
        let acts = event.what.by().is_some() && MarkKind::of(&event.what) != MarkKind::Other;
        self.operations += u64::from(acts);
        self.list.add(event);
    }
}
