//! Who competes in each group, as its next selection sees it. Kept from one selection to the next, since most of a group has not
//! changed meanwhile: a selection looks again at those schemas only that something happened to.
//!
//! It says again what the schemas' own facts say and decides nothing. What it keeps beside them is no part of what the hierarchy is:
//! all of it can be made anew from them.

use std::sync::Arc;

use super::Hierarchy;
use super::plan::Plan;
use crate::record::Candidate;
use crate::spec::{GroupId, SchemaId};
use crate::state::State;

/// The awake members of a group that somebody wants, in the father's order.
#[derive(Clone, Debug)]
pub(super) struct Lineup {
    /// Shared with the records that were made over it, and copied before it changes if one of them is kept.
    pub(super) candidates: Arc<[Candidate]>,
    /// The place of the first that is ready.
    pub(super) first: Option<usize>,
    /// Whether another one is ready too.
    pub(super) several: bool,
}

/// The line-ups of all groups.
#[derive(Clone, Debug)]
pub(super) struct Lineups {
    groups: Vec<Kept>,
    /// Of each schema.
    touched: Vec<bool>,
}

#[derive(Clone, Debug, Default)]
struct Kept {
    candidates: Arc<[Candidate]>,
    /// A bit for each candidate that is ready.
    ready: Vec<u64>,
    /// Members whose facts may have changed since, each once.
    touched: Vec<SchemaId>,
}

impl Lineups {
    pub(super) fn new(schemas: usize, groups: usize) -> Self {
        Self {
            groups: vec![Kept::default(); groups],
            touched: vec![false; schemas],
        }
    }

    /// Something happens to a schema.
    #[inline]
    pub(super) fn touch(&mut self, plan: &Plan, id: SchemaId) {
        if let Some(group) = plan.group_of(id)
            && !std::mem::replace(&mut self.touched[id.index()], true)
        {
            self.groups[group.index()].touched.push(id);
        }
    }
}

/// Hierarchies are equal whatever they keep beside their facts.
impl PartialEq for Lineups {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

impl Eq for Lineups {}

impl Hierarchy {
    /// Who competes in a group now.
    pub(super) fn lineup(&mut self, id: GroupId) -> Lineup {
        let mut kept = std::mem::take(&mut self.lineups.groups[id.index()]);
        let mut whole = true;
        for member in kept.touched.drain(..) {
            self.lineups.touched[member.index()] = false;
            let known = kept
                .candidates
                .binary_search_by_key(&self.plan.place_of(member), |known| self.plan.place_of(known.id));
            match (known, self.candidate(member)) {
                (Ok(place), Some(candidate)) if kept.candidates[place] != candidate => {
                    Arc::make_mut(&mut kept.candidates)[place] = candidate;
                    let bit = 1 << (place % 64);
                    if candidate.ready {
                        kept.ready[place / 64] |= bit;
                    } else {
                        kept.ready[place / 64] &= !bit;
                    }
                }
                (Ok(_), Some(_)) | (Err(_), None) => {}
                (Ok(_), None) | (Err(_), Some(_)) => whole = false,
            }
        }
        if !whole {
            self.line_up(id, &mut kept);
        }
        debug_assert!(self.is_right(id, &kept), "a change that nobody was told of");
        let mut ready = kept.ready.iter().enumerate().filter(|(_, word)| **word != 0);
        let (first, several) = match ready.next() {
            None => (None, false),
            Some((place, word)) => {
                let first = 64 * place + word.trailing_zeros() as usize;
                (Some(first), !word.is_power_of_two() || ready.next().is_some())
            }
        };
        let lineup = Lineup {
            candidates: Arc::clone(&kept.candidates),
            first,
            several,
        };
        self.lineups.groups[id.index()] = kept;
        lineup
    }

    /// Looks at all members.
    fn line_up(&self, id: GroupId, kept: &mut Kept) {
        let members = self.plan.members(id).iter();
        kept.candidates = members.filter_map(|&member| self.candidate(member)).collect();
        kept.ready.clear();
        kept.ready.resize(kept.candidates.len().div_ceil(64), 0);
        for (place, candidate) in kept.candidates.iter().enumerate() {
            kept.ready[place / 64] |= u64::from(candidate.ready) << (place % 64);
        }
    }

    /// Whether what is kept is what would be made anew.
    fn is_right(&self, id: GroupId, kept: &Kept) -> bool {
        let mut anew = Kept::default();
        self.line_up(id, &mut anew);
        kept.candidates == anew.candidates && kept.ready == anew.ready
    }

    /// A member as a selection sees it, if it competes.
    fn candidate(&self, id: SchemaId) -> Option<Candidate> {
        let node = self.node(id);
        (node.state != State::Slept && node.wanted()).then(|| Candidate {
            id,
            state: node.state,
            ready: node.ready,
            urgency: node.urgency.get(),
        })
    }
}
