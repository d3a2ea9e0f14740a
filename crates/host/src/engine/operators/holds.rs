//! The actions of operators that are in force, and what they overwrote.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use jde_board::Variable;

/// The actions of operators that were not released yet.
#[derive(Default)]
pub(super) struct OperatorHolds {
    /// The operator that last played, stopped or forced each schema.
    pub(super) operators: BTreeMap<usize, String>,
    /// The operator that last stopped everything.
    pub(super) stop_all_operator: String,
    /// Schemas whose instances were ended by unloading.
    pub(super) unloaded: BTreeSet<usize>,
    pub(super) values: Vec<Overwritten>,
    /// The operator that last let each export fail, by instance and port.
    pub(super) failing: BTreeMap<(usize, usize), String>,
}

/// A modulation or period that an operator overwrote.
pub(super) struct Overwritten {
    pub(super) owner: usize,
    pub(super) variable: Arc<Variable>,
    pub(super) previous: PreviousValue,
    pub(super) by: String,
}

pub(super) struct PreviousValue {
    pub(super) writer: u32,
    pub(super) bytes: Vec<u8>,
}

impl OperatorHolds {
    /// Records the operator that plays, stops or forces a schema.
    pub(super) fn set_hold(&mut self, instance: usize, by: &str) {
        self.operators.insert(instance, by.to_owned());
    }

    /// Whether this operator was the last to play, stop or force the schema.
    pub(super) fn is_held_by(&self, instance: usize, by: &str) -> bool {
        self.operators
            .get(&instance)
            .is_some_and(|operator| operator == by)
    }

    /// Forgets the hold on a schema.
    pub(super) fn remove_hold(&mut self, instance: usize) {
        self.operators.remove(&instance);
        self.unloaded.remove(&instance);
    }
}
