//! All schemas at run time, with the candidate lists that follow from their facts.
//!
//! The lists stay right because no fact of a candidate changes past this type.

use std::hash::{Hash, Hasher};

use super::candidates::{CandidateCache, CandidateList};
use super::last_check::{CheckChange, Urgency};
use super::node::{IterationEnd, Node};
use super::spec_index::SpecIndex;
use crate::spec::{GroupId, SchemaId, Spec};
use crate::table::Table;

/// The schemas, by their identifiers.
#[derive(Clone, PartialEq, Eq, Debug)]
pub(super) struct Nodes {
    nodes: Table<SchemaId, Node>,
    candidates: CandidateCache,
}

static UNKNOWN: Node = Node::ASLEEP;

impl Nodes {
    pub(super) fn new(spec: &Spec) -> Self {
        Self {
            nodes: spec.schemas.map_ids(|_| Node::ASLEEP),
            candidates: CandidateCache::new(spec),
        }
    }

    /// Returns the facts of a schema; those of a sleeping one for an unknown identifier.
    #[inline]
    pub(super) fn get(&self, id: SchemaId) -> &Node {
        self.nodes.get(id).unwrap_or(&UNKNOWN)
    }

    /// Returns the facts of a known schema for a change.
    #[inline]
    pub(super) fn get_mut(&mut self, plan: &SpecIndex, id: SchemaId) -> &mut Node {
        self.candidates.mark_dirty(plan, id);
        &mut self.nodes[id]
    }

    /// Takes in the check of a known schema. Returns whether its readiness changed or became known.
    #[inline]
    pub(super) fn check(&mut self, plan: &SpecIndex, id: SchemaId, ready: bool, urgency: Urgency) -> bool {
        let change = self.nodes[id].check(ready, urgency);
        if change != CheckChange::Nothing {
            self.candidates.mark_dirty(plan, id);
        }
        change == CheckChange::Readiness
    }

    /// Begins an iteration of a known schema. No candidate list depends on iterations.
    #[inline]
    pub(super) fn begin(&mut self, id: SchemaId) {
        self.nodes[id].begin();
    }

    /// Ends an iteration of a known schema.
    #[inline]
    pub(super) fn end(&mut self, id: SchemaId) -> IterationEnd {
        self.nodes[id].end()
    }

    /// Returns the current candidate list of a group.
    #[inline]
    pub(super) fn candidates_of(&mut self, plan: &SpecIndex, id: GroupId) -> CandidateList {
        self.candidates.list(plan, &self.nodes, id)
    }
}

/// The lists follow from the schemas, so they are not hashed.
impl Hash for Nodes {
    fn hash<H: Hasher>(&self, state: &mut H) {
        self.nodes.hash(state);
    }
}
