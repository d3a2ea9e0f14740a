//! Questions about the hierarchy as it is now.
//!
//! Read only. An identifier that does not exist reads as a sleeping, healthy schema or an empty group.

use super::parts::{Node, Run};
use super::{Handover, Hierarchy};
use crate::contract::{allowed, arbitration};
use crate::spec::{GroupId, Nanos, SchemaId, Spec};
use crate::state::{Health, Requester, Standing, State};

impl Hierarchy {
    /// The state of a schema.
    #[must_use]
    pub fn state(&self, id: SchemaId) -> State {
        self.nodes.get(id.index()).map_or(State::Slept, |n| n.state)
    }

    /// The health of a schema.
    #[must_use]
    pub fn health(&self, id: SchemaId) -> &Health {
        self.nodes.get(id.index()).map_or(&Health::Ok, |n| &n.health)
    }

    /// Whether a schema is not SLEPT.
    #[must_use]
    pub fn is_awake(&self, id: SchemaId) -> bool {
        self.state(id) != State::Slept
    }

    /// Whether the precondition of a schema held at its last check.
    #[must_use]
    pub fn is_ready(&self, id: SchemaId) -> bool {
        self.nodes.get(id.index()).is_some_and(|n| n.ready)
    }

    /// Whether a schema was checked since it woke.
    #[must_use]
    pub fn is_checked(&self, id: SchemaId) -> bool {
        self.nodes.get(id.index()).is_some_and(|n| n.checked)
    }

    /// Whether an iteration of this schema runs, abandoned or not.
    #[must_use]
    pub fn is_running(&self, id: SchemaId) -> bool {
        self.nodes.get(id.index()).is_some_and(|n| n.run != Run::Between)
    }

    /// Whether an iteration of this schema still runs although it lost its place or was put to sleep.
    #[must_use]
    pub fn is_abandoned(&self, id: SchemaId) -> bool {
        self.nodes
            .get(id.index())
            .is_some_and(|n| n.run == Run::Abandoned)
    }

    /// Whether a command of this schema may reach an actuator and a child of it may be woken at this instant (R7):
    /// it and all its fathers are WINNER, and it was not withdrawn. Never true for a perceptive schema.
    #[must_use]
    pub fn has_authority(&self, id: SchemaId) -> bool {
        self.nodes.get(id.index()).is_some_and(|n| n.authority)
    }

    /// Whether it is awake and ready, or has not been checked since it woke.
    #[must_use]
    pub fn could_act(&self, id: SchemaId) -> bool {
        let could = |node: &Node| node.ready || !node.checked;
        self.is_awake(id) && self.nodes.get(id.index()).is_some_and(could)
    }

    /// Whether an operator stopped this schema, by itself or with everything.
    #[must_use]
    pub fn is_stopped(&self, id: SchemaId) -> bool {
        self.nodes.get(id.index()).is_some_and(Node::is_stopped)
    }

    /// Whether an operator stopped everything, this schema among it, and did not let it go on.
    #[must_use]
    pub fn is_stopped_with_all(&self, id: SchemaId) -> bool {
        self.nodes.get(id.index()).is_some_and(|n| n.stopped_with_all)
    }

    /// Who wants this schema awake, sorted.
    #[must_use]
    pub fn requesters(&self, id: SchemaId) -> &[Requester] {
        self.nodes.get(id.index()).map_or(&[], |n| &n.requesters)
    }

    /// Whether a motor schema became WINNER and has not begun an iteration since: it should, at once.
    #[must_use]
    pub fn is_taking(&self, id: SchemaId) -> bool {
        self.group_of(id).is_some_and(|group| {
            let group = self.group(group);
            group.winner == Some(id) && group.taking.is_some()
        })
    }

    /// The member of a group whose state is WINNER.
    #[must_use]
    pub fn winner(&self, group: GroupId) -> Option<SchemaId> {
        self.groups.get(group.index())?.winner
    }

    /// The handover under way in a group, away from its winner.
    #[must_use]
    pub fn handover(&self, group: GroupId) -> Option<Handover> {
        self.groups.get(group.index())?.handover
    }

    /// What the actuators do on behalf of a group.
    #[must_use]
    pub fn standing(&self, group: GroupId) -> Standing {
        self.groups
            .get(group.index())
            .map_or(Standing::Fresh, |g| g.standing)
    }

    /// The member an operator forces.
    #[must_use]
    pub fn forced(&self, group: GroupId) -> Option<SchemaId> {
        self.groups.get(group.index())?.forced
    }

    /// The ticket of the question to the father that is open in a group.
    #[must_use]
    pub fn asked(&self, group: GroupId) -> Option<u64> {
        self.groups.get(group.index())?.asked.as_ref().map(|a| a.ticket)
    }

    /// The father of a motor schema.
    #[must_use]
    pub fn father(&self, id: SchemaId) -> Option<SchemaId> {
        if self.plan.knows(id) {
            self.plan.father(id)
        } else {
            None
        }
    }

    /// The group in which a motor schema competes.
    #[must_use]
    pub fn group_of(&self, id: SchemaId) -> Option<GroupId> {
        if self.plan.knows(id) {
            self.plan.group_of(id)
        } else {
            None
        }
    }

    /// The motor schemas below a schema, children before fathers; without itself.
    #[must_use]
    pub fn subtree(&self, id: SchemaId) -> Vec<SchemaId> {
        let mut below = Vec::new();
        if self.plan.knows(id) {
            self.collect_below(id, &mut below);
        }
        below
    }

    /// The specification, with the policies and periods that are in force now.
    #[must_use]
    pub fn spec(&self) -> &Spec {
        &self.plan.spec
    }

    /// How long a takeover in a group may take from its cause, by the policies and periods that are in force now (R17); it
    /// allocates nothing.
    #[must_use]
    pub fn allowed(&self, group: GroupId) -> Option<Nanos> {
        let own = |id| {
            let groups = self.plan.groups_under(id).iter();
            groups.map(|group| arbitration(self.plan.group(*group))).sum()
        };
        allowed(self.spec(), group, &own)
    }

    fn collect_below(&self, id: SchemaId, below: &mut Vec<SchemaId>) {
        for &group in self.plan.groups_under(id) {
            for &member in self.plan.members(group) {
                self.collect_below(member, below);
                below.push(member);
            }
        }
    }
}
