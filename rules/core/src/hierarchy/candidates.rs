//! The candidate list of each group for its next selection. It is cached between selections, because most
//! members do not change. A selection re-reads only the members that changed.
//!
//! It decides nothing. The lists are a cache: they can be rebuilt from the schemas' facts, and are no part of
//! the state of a hierarchy.

use std::sync::Arc;

use super::node::Node;
use super::spec_index::SpecIndex;
use crate::record::Candidate;
use crate::spec::{GroupId, SchemaId, Spec};
use crate::table::Table;

/// The members of a group that are awake and should stay awake, in the father's order.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct CandidateList {
    /// Shared with the records of the selections over it. It is copied before a change if such a record still
    /// exists.
    pub(super) candidates: Arc<[Candidate]>,
    /// The index of the first READY candidate.
    pub(super) first: Option<usize>,
    /// Whether another candidate is READY too.
    pub(super) several: bool,
}

/// The candidate lists of all groups.
#[derive(Clone, Debug)]
pub(super) struct CandidateCache {
    groups: Table<GroupId, CachedCandidates>,
    /// Whether a schema is in its group's `dirty` list; one entry for each schema.
    dirty: Table<SchemaId, bool>,
}

#[derive(Clone, Debug, Default, PartialEq)]
struct CachedCandidates {
    list: CandidateList,
    /// One bit for each candidate, set if it is READY.
    ready: Vec<u64>,
    /// Members whose facts may have changed since the last selection, each once.
    dirty: Vec<SchemaId>,
}

impl CandidateCache {
    pub(super) fn new(spec: &Spec) -> Self {
        Self {
            groups: spec.groups.map_ids(|_| CachedCandidates::default()),
            dirty: spec.schemas.map_ids(|_| false),
        }
    }

    /// Marks a schema whose facts may change.
    #[inline]
    pub(super) fn mark_dirty(&mut self, plan: &SpecIndex, id: SchemaId) {
        if let Some(group) = plan.group_of(id)
            && !std::mem::replace(&mut self.dirty[id], true)
        {
            self.groups[group].dirty.push(id);
        }
    }

    /// Returns the current candidate list of a group.
    #[inline]
    pub(super) fn list(
        &mut self,
        plan: &SpecIndex,
        nodes: &Table<SchemaId, Node>,
        id: GroupId,
    ) -> CandidateList {
        let cached = &mut self.groups[id];
        if !cached.dirty.is_empty() {
            cached.refresh(plan, nodes, id, &mut self.dirty);
        }
        debug_assert!(
            *cached == CachedCandidates::of(plan, nodes, id),
            "a change that was not reported"
        );
        cached.list.clone()
    }
}

/// Equal always: the lists are a cache, and equality of hierarchies is equality of their facts.
impl PartialEq for CandidateCache {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

impl Eq for CandidateCache {}

impl CachedCandidates {
    /// Builds the candidate list of a group from the facts of its members.
    fn of(plan: &SpecIndex, nodes: &Table<SchemaId, Node>, id: GroupId) -> Self {
        let members = plan.members(id).iter();
        let candidates: Arc<[Candidate]> = members
            .filter_map(|&member| nodes[member].candidate(member))
            .collect();
        let mut ready = vec![0; candidates.len().div_ceil(64)];
        for (position, candidate) in candidates.iter().enumerate() {
            ready[position / 64] |= u64::from(candidate.ready) << (position % 64);
        }
        let (first, several) = first_ready(&ready);
        Self {
            list: CandidateList {
                candidates,
                first,
                several,
            },
            ready,
            dirty: Vec::new(),
        }
    }

    /// Re-reads the dirty members. Rebuilds the list if a member joined or left the candidates.
    fn refresh(
        &mut self,
        plan: &SpecIndex,
        nodes: &Table<SchemaId, Node>,
        id: GroupId,
        dirty: &mut Table<SchemaId, bool>,
    ) {
        let mut is_complete = true;
        let candidates = &mut self.list.candidates;
        for member in self.dirty.drain(..) {
            dirty[member] = false;
            let position = plan.position_of(member);
            let found = if candidates.get(position).is_some_and(|found| found.id == member) {
                Ok(position)
            } else {
                candidates.binary_search_by_key(&position, |found| plan.position_of(found.id))
            };
            match (found, nodes[member].candidate(member)) {
                (Ok(position), Some(candidate)) if candidates[position] != candidate => {
                    Arc::make_mut(candidates)[position] = candidate;
                    let bit = 1 << (position % 64);
                    if candidate.ready {
                        self.ready[position / 64] |= bit;
                    } else {
                        self.ready[position / 64] &= !bit;
                    }
                }
                (Ok(_), Some(_)) | (Err(_), None) => {}
                (Ok(_), None) | (Err(_), Some(_)) => is_complete = false,
            }
        }
        if is_complete {
            (self.list.first, self.list.several) = first_ready(&self.ready);
        } else {
            *self = Self::of(plan, nodes, id);
        }
    }
}

/// Returns the index of the first bit that is set, and whether another one is.
fn first_ready(ready: &[u64]) -> (Option<usize>, bool) {
    let mut words = ready.iter().enumerate().filter(|(_, word)| **word != 0);
    match words.next() {
        None => (None, false),
        Some((position, word)) => {
            let first = 64 * position + word.trailing_zeros() as usize;
            (Some(first), !word.is_power_of_two() || words.next().is_some())
        }
    }
}
