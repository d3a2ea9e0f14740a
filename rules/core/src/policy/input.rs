//! The input of a policy. It refuses to hold authority, and to use any time other than the given one.

use crate::record::Candidate;
use crate::spec::{Nanos, SchemaId};

/// The input of a policy.
#[derive(Copy, Clone)]
pub(crate) struct PolicyInput<'a> {
    /// The awake members in the father's order; at least one is READY.
    pub(crate) candidates: &'a [Candidate],
    /// The index of the first READY candidate.
    pub(crate) first: Option<usize>,
    /// All members in the father's order.
    pub(crate) members: &'a [SchemaId],
    /// The current choice.
    pub(crate) chosen: Option<SchemaId>,
    /// When the current choice was made.
    pub(crate) since: Nanos,
    /// The last choice, current or past.
    pub(crate) last: Option<SchemaId>,
    pub(crate) now: Nanos,
}

/// A choice and its reason; `None` only if no candidate is READY.
pub(crate) type Choice = Option<(SchemaId, &'static str)>;

impl PolicyInput<'_> {
    pub(super) fn ready(&self) -> impl Iterator<Item = &Candidate> {
        self.candidates.iter().filter(|c| c.ready)
    }

    /// Returns the current choice if it is READY.
    pub(super) fn incumbent(&self) -> Option<&Candidate> {
        self.ready().find(|c| Some(c.id) == self.chosen)
    }

    /// Returns how long the current choice has lasted.
    pub(super) fn elapsed(&self) -> Nanos {
        self.now.saturating_sub(self.since)
    }

    /// Returns the first in the father's order among the most urgent.
    pub(super) fn most_urgent(&self) -> Option<&Candidate> {
        self.ready()
            .reduce(|top, c| if c.urgency > top.urgency { c } else { top })
    }
}
