//! When each schema held authority, and which groups hold their last command. Commands are judged by this
//! history. Only the last spans of each schema are stored; older ones are not needed.

use std::collections::{BTreeMap, VecDeque};

use jde_core::{GroupId, Nanos, SchemaId, Spec, State, Table};

/// Spans of authority stored per schema: more than occur between two judgements.
const MAX_SPANS: usize = 64;

/// The history since the start.
#[derive(Debug, Default)]
pub(crate) struct History {
    spans: Table<SchemaId, VecDeque<(Nanos, Option<Nanos>)>>,
    states: Table<SchemaId, State>,
    holds: BTreeMap<GroupId, Nanos>,
    group_of: Table<SchemaId, Option<GroupId>>,
    fathers: Table<GroupId, Option<SchemaId>>,
    members: Table<GroupId, Vec<SchemaId>>,
}

/// The status of the authority behind a command.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum AuthorityStatus {
    /// Its writer holds authority.
    Holds,
    /// This schema won instead, and has not commanded yet. Correct if the schema or one of its
    /// descendants commands the same (R7).
    TakenOver(SchemaId),
    /// No schema won, and the group holds its last command for a time (R9).
    HeldByPolicy,
    /// No schema won in this group, which should have braked (R9).
    Orphan(GroupId),
}

impl History {
    /// Reads the hierarchy.
    pub(crate) fn begin(&mut self, spec: &Spec) {
        self.spans = spec.schemas.map_ids(|_| VecDeque::new());
        self.states = spec.schemas.map_ids(|_| State::Slept);
        self.group_of = spec.schemas.map_ids(|_| None);
        self.fathers = spec.groups.iter().map(|group| group.father).collect();
        self.members = spec.groups.iter().map(|group| group.members.clone()).collect();
        for (group, members) in self.members.entries() {
            for member in members {
                self.group_of[*member] = Some(group);
            }
        }
    }

    pub(crate) fn has_begun(&self) -> bool {
        !self.states.is_empty()
    }

    pub(crate) fn granted(&mut self, id: SchemaId, at: Nanos) {
        let spans = &mut self.spans[id];
        if spans.back().is_some_and(|(_, end)| end.is_none()) {
            return;
        }
        if spans.len() == MAX_SPANS {
            spans.pop_front();
        }
        spans.push_back((at, None));
    }

    pub(crate) fn withdrawn(&mut self, id: SchemaId, at: Nanos) {
        if let Some((_, end @ None)) = self.spans[id].back_mut() {
            *end = Some(at);
        }
    }

    pub(crate) fn changed(&mut self, id: SchemaId, to: State) {
        self.states[id] = to;
    }

    pub(crate) fn holds(&mut self, group: GroupId, until: Nanos) {
        self.holds.insert(group, until);
    }

    /// A schema gains authority in a group: held commands of this group and those below end (R9).
    pub(crate) fn taken_over(&mut self, group: GroupId, at: Nanos) {
        let groups: Vec<GroupId> = self.holds.keys().copied().collect();
        for held in groups {
            let path = std::iter::successors(Some(held), |group| self.group_of[self.fathers[*group]?]);
            if path.into_iter().any(|above| above == group)
                && let Some(until) = self.holds.get_mut(&held)
            {
                *until = at.min(*until);
            }
        }
    }

    /// Whether a schema is another one or its descendant.
    pub(crate) fn is_of(&self, schema: SchemaId, above: SchemaId) -> bool {
        let father = |schema: &SchemaId| self.fathers[self.group_of[*schema]?];
        std::iter::successors(Some(schema), father).any(|ancestor| ancestor == above)
    }

    /// Whether the schema held authority at any instant from `from` to `to`.
    pub(crate) fn held_authority(&self, schema: SchemaId, from: Nanos, to: Nanos) -> bool {
        let Some(spans) = self.spans.get(schema) else {
            return false;
        };
        spans
            .iter()
            .any(|(begin, end)| *begin <= to && end.is_none_or(|end| end >= from))
    }

    /// Whether an absence policy holds the last command of the schema or of one above it, at any instant from
    /// `from` on.
    pub(crate) fn is_held(&self, schema: SchemaId, from: Nanos) -> bool {
        let mut at = Some(schema);
        while let Some(group) = at.and_then(|schema| self.group_of[schema]) {
            if self.holds.get(&group).is_some_and(|until| *until >= from) {
                return true;
            }
            at = self.fathers[group];
        }
        false
    }

    /// Whether the father of a group took over a command that was given at that time, and none of the group
    /// has won since (R7). So it is after a guard refused the command of whoever won meanwhile (R18).
    fn father_took_over(&self, group: GroupId, given: Nanos) -> Option<SchemaId> {
        let father = self.fathers[group]?;
        let (begin, end) = *self.spans[father].back()?;
        let has_won = |member: &SchemaId| self.spans[*member].back().is_some_and(|(won, _)| *won >= begin);
        let takes_over = end.is_none() && begin >= given && !self.members[group].iter().any(has_won);
        takes_over.then_some(father)
    }

    /// The status of this schema's command, given at this time. The highest group on its path in which another schema or none won
    /// determines it: groups below sleep for that reason and need not brake.
    pub(crate) fn status(&self, writer: SchemaId, given: Nanos, now: Nanos) -> AuthorityStatus {
        let mut status = AuthorityStatus::Holds;
        let mut at = Some(writer);
        while let Some((schema, group)) = at.and_then(|schema| Some((schema, self.group_of[schema]?))) {
            let mut members = self.members[group].iter();
            match members.find(|member| self.states[**member] == State::Winner) {
                Some(winner) if *winner == schema => {}
                Some(winner) => status = AuthorityStatus::TakenOver(*winner),
                None if self.holds.get(&group).is_some_and(|until| *until >= now) => {
                    status = AuthorityStatus::HeldByPolicy
                }
                None => {
                    let father = self.father_took_over(group, given);
                    status = father.map_or(AuthorityStatus::Orphan(group), AuthorityStatus::TakenOver);
                }
            }
            at = self.fathers[group];
        }
        status
    }
}
