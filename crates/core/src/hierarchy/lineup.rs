//! Who competes in each group, as its next selection sees it. Kept from one selection to the next, since most of a group has not
//! changed meanwhile: a selection looks again at those schemas only that something happened to.
//!
//! It says again what the schemas' own facts say and decides nothing. What it keeps beside them is no part of what the hierarchy is:
//! all of it can be made anew from them.

use std::sync::Arc;

use super::Hierarchy;
use super::parts::Node;
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

#[derive(Clone, Debug, Default, PartialEq)]
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
        let Self {
            plan, nodes, lineups, ..
        } = self;
        let Lineups { groups, touched } = lineups;
        let kept = &mut groups[id.index()];
        if !kept.touched.is_empty() && !kept.catch_up(plan, nodes, touched) {
            *kept = Kept::of(plan, nodes, id);
        }
        debug_assert!(
            *kept == Kept::of(plan, nodes, id),
            "a change that nobody was told of"
        );
        kept.lineup()
    }
}

impl Kept {
    /// A group looked at anew.
    fn of(plan: &Plan, nodes: &[Node], id: GroupId) -> Self {
        let members = plan.members(id).iter();
        let candidates: Arc<[Candidate]> = members.filter_map(|&member| candidate(nodes, member)).collect();
        let mut ready = vec![0; candidates.len().div_ceil(64)];
        for (place, candidate) in candidates.iter().enumerate() {
            ready[place / 64] |= u64::from(candidate.ready) << (place % 64);
        }
        Self {
            candidates,
            ready,
            touched: Vec::new(),
        }
    }

    /// Looks again at those to whom something happened; false if somebody else competes than before.
    fn catch_up(&mut self, plan: &Plan, nodes: &[Node], touched: &mut [bool]) -> bool {
        let mut whole = true;
        for member in self.touched.drain(..) {
            touched[member.index()] = false;
            let place = plan.place_of(member);
            let known = if self.candidates.get(place).is_some_and(|known| known.id == member) {
                Ok(place)
            } else {
                self.candidates
                    .binary_search_by_key(&place, |known| plan.place_of(known.id))
            };
            match (known, candidate(nodes, member)) {
                (Ok(place), Some(candidate)) if self.candidates[place] != candidate => {
                    Arc::make_mut(&mut self.candidates)[place] = candidate;
                    let bit = 1 << (place % 64);
                    if candidate.ready {
                        self.ready[place / 64] |= bit;
                    } else {
                        self.ready[place / 64] &= !bit;
                    }
                }
                (Ok(_), Some(_)) | (Err(_), None) => {}
                (Ok(_), None) | (Err(_), Some(_)) => whole = false,
            }
        }
        whole
    }

    fn lineup(&self) -> Lineup {
        let mut ready = self.ready.iter().enumerate().filter(|(_, word)| **word != 0);
        let (first, several) = match ready.next() {
            None => (None, false),
            Some((place, word)) => {
                let first = 64 * place + word.trailing_zeros() as usize;
                (Some(first), !word.is_power_of_two() || ready.next().is_some())
            }
        };
        Lineup {
            candidates: Arc::clone(&self.candidates),
            first,
            several,
        }
    }
}

/// A member as a selection sees it, if it competes.
fn candidate(nodes: &[Node], id: SchemaId) -> Option<Candidate> {
    let node = &nodes[id.index()];
    (node.state != State::Slept && node.wanted()).then(|| Candidate {
        id,
        state: node.state,
        ready: node.ready,
        urgency: node.urgency.get(),
    })
}
