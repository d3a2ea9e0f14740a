//! Operators' holds on one schema (R14): who plays it, and who stops it.
//!
//! Data with its transitions; it refuses to decide what follows from a change. A force competes with those on
//! siblings, so the group keeps it.

use crate::state::{Hold, HoldAction, Holder};

/// Oldest first, each once.
#[derive(Clone, PartialEq, Eq, Hash, Debug)]
pub(super) struct Holds(Vec<Hold>);

impl Holds {
    pub(super) const NONE: Self = Self(Vec::new());

    pub(super) fn iter(&self) -> impl Iterator<Item = Hold> {
        self.0.iter().copied()
    }

    pub(super) fn is_stopped(&self) -> bool {
        self.iter().any(|hold| hold.action.stops())
    }

    /// Returns the first stop of somebody else.
    pub(super) fn stop_of_another(&self, by: Holder) -> Option<Hold> {
        self.iter().find(|hold| hold.action.stops() && hold.by != by)
    }

    pub(super) fn contains(&self, action: HoldAction) -> bool {
        self.iter().any(|hold| hold.action == action)
    }

    /// Whether what it needed stays awake: an operator stopped it, and nobody unloaded it.
    pub(super) fn keep_needs(&self) -> bool {
        self.is_stopped() && !self.contains(HoldAction::Unloaded)
    }

    pub(super) fn add(&mut self, hold: Hold) {
        if !self.0.contains(&hold) {
            self.0.push(hold);
        }
    }

    /// Ends holds; returns whether there were any.
    pub(super) fn end(&mut self, which: impl Fn(Hold) -> bool) -> bool {
        let before = self.0.len();
        self.0.retain(|hold| !which(*hold));
        self.0.len() < before
    }
}
