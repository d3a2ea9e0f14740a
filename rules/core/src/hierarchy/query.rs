//! Queries of the current state of the hierarchy.
//!
//! Read only. An unknown identifier reads as a sleeping, healthy schema or an empty group.

use super::group::Group;
use super::snapshot::forced_choice;
use super::{Handover, Hierarchy};
use crate::contract::{allowed, arbitration};
use crate::spec::{GroupId, Nanos, SchemaId, Spec};
use crate::state::{ActuationState, Health, Hold, HoldAction, Holder, Requester, State};

impl Hierarchy {
    /// Returns the state of a schema.
    #[must_use]
    pub fn state(&self, id: SchemaId) -> State {
        self.node(id).state()
    }

    /// Returns the health of a schema.
    #[must_use]
    pub fn health(&self, id: SchemaId) -> &Health {
        self.node(id).health()
    }

    /// Returns how many restarts its policy still grants at this time; `None` if it is never restarted.
    #[must_use]
    pub fn restarts_left(&self, now: Nanos, id: SchemaId) -> Option<u32> {
        if !self.plan.contains(id) {
            return None;
        }
        self.restarts[id].left(self.plan.schema(id).restart, now)
    }

    /// Returns whether a schema is not SLEPT.
    #[must_use]
    pub fn is_awake(&self, id: SchemaId) -> bool {
        self.node(id).is_awake()
    }

    /// Returns whether the precondition of a schema was true at its last check, and no guard has refused a
    /// command of it since its last retry (R18).
    #[must_use]
    pub fn is_ready(&self, id: SchemaId) -> bool {
        self.node(id).is_ready()
    }

    /// Returns whether a guard refused a command of this schema and its retry has not ended (R18).
    #[must_use]
    pub fn is_refused(&self, id: SchemaId) -> bool {
        self.node(id).is_refused()
    }

    /// Returns whether a schema has checked since it woke.
    #[must_use]
    pub fn is_checked(&self, id: SchemaId) -> bool {
        self.node(id).is_checked()
    }

    /// Returns whether an iteration of this schema runs, abandoned or not.
    #[must_use]
    pub fn is_running(&self, id: SchemaId) -> bool {
        self.node(id).is_running()
    }

    /// Returns whether an iteration of this schema still runs although the schema was replaced or put to
    /// sleep.
    #[must_use]
    pub fn is_abandoned(&self, id: SchemaId) -> bool {
        self.node(id).is_abandoned()
    }

    /// Returns whether an iteration may begin before the check of its turn: this schema is WINNER and READY,
    /// and has nothing to take over. Such an iteration ends where the check finds the precondition false,
    /// unless it [should go on](Self::should_go_on).
    #[must_use]
    pub fn may_begin_early(&self, id: SchemaId) -> bool {
        let node = self.node(id);
        node.is_ready() && node.has_taken_over() && !self.is_taking(id)
    }

    /// Returns whether an iteration of this schema runs, and the schema is still WINNER and not about to be
    /// replaced.
    #[must_use]
    pub fn should_go_on(&self, id: SchemaId) -> bool {
        let node = self.node(id);
        node.is_iterating() && node.should_be_awake() && self.handover_above(id).is_none()
    }

    /// Returns whether, at this instant, a command of this schema may reach an actuator and a child of it may
    /// be woken (R7): the schema and all its fathers are WINNER, and its authority is not withdrawn. Never
    /// true for a perceptive schema.
    #[must_use]
    pub fn has_authority(&self, id: SchemaId) -> bool {
        self.node(id).has_authority()
    }

    /// Returns whether it is awake and READY, or has not checked since it woke.
    #[must_use]
    pub fn could_act(&self, id: SchemaId) -> bool {
        let node = self.node(id);
        node.is_awake() && (node.is_ready() || !node.is_checked())
    }

    /// Returns whether an operator holds this schema asleep.
    #[must_use]
    pub fn is_stopped(&self, id: SchemaId) -> bool {
        self.node(id).is_stopped()
    }

    /// Returns what operators hold this schema to (R14): stops and plays in the order in which they began, then
    /// forces, newest first.
    pub fn holds(&self, id: SchemaId) -> impl Iterator<Item = Hold> {
        let group = self.group_of(id).map(|group| self.group(group));
        let forces = group.into_iter().flat_map(Group::forces);
        let forces = forces
            .filter(move |(_, forced)| *forced == id)
            .map(|(by, _)| Hold {
                by,
                action: HoldAction::Forced,
            });
        self.node(id).holds().iter().chain(forces)
    }

    /// Returns the requesters that keep this schema awake, sorted.
    #[must_use]
    pub fn requesters(&self, id: SchemaId) -> &[Requester] {
        self.node(id).requesters()
    }

    /// Returns whether a motor schema became WINNER and has not begun an iteration since. It should begin one
    /// at once.
    #[must_use]
    pub fn is_taking(&self, id: SchemaId) -> bool {
        self.group_of(id)
            .is_some_and(|group| self.group(group).is_taking(id))
    }

    /// Returns the member of a group whose state is WINNER.
    #[must_use]
    pub fn winner(&self, group: GroupId) -> Option<SchemaId> {
        self.group(group).winner()
    }

    /// Returns the handover under way in a group, away from its winner.
    #[must_use]
    pub fn handover(&self, group: GroupId) -> Option<Handover> {
        self.group(group).handover()
    }

    /// Returns what the actuators do on behalf of a group.
    #[must_use]
    pub fn actuation(&self, group: GroupId) -> ActuationState {
        self.group(group).actuation()
    }

    /// Returns the forces of operators in a group, newest first.
    pub fn forces(&self, group: GroupId) -> impl Iterator<Item = (Holder, SchemaId)> {
        self.group(group).forces()
    }

    /// Returns the member that operators force: that of the newest force whose schema can win.
    #[must_use]
    pub fn forced(&self, group: GroupId) -> Option<SchemaId> {
        forced_choice(self.group(group), &self.nodes)
    }

    /// Returns the ticket of the open arbitration request to the father of a group.
    #[must_use]
    pub fn pending_arbitration(&self, group: GroupId) -> Option<u64> {
        self.group(group).pending().map(|open| open.ticket)
    }

    /// Returns the father of a motor schema.
    #[must_use]
    pub fn father(&self, id: SchemaId) -> Option<SchemaId> {
        self.plan.father(id)
    }

    /// Returns the group in which a motor schema competes.
    #[must_use]
    pub fn group_of(&self, id: SchemaId) -> Option<GroupId> {
        self.plan.group_of(id)
    }

    /// Returns the motor schemas below a schema, children before fathers, without the schema itself.
    #[must_use]
    pub fn subtree(&self, id: SchemaId) -> Vec<SchemaId> {
        let mut below = Vec::new();
        if self.plan.contains(id) {
            self.collect_below(id, &mut below);
        }
        below
    }

    /// Returns the specification, with the policies and periods that are in force now.
    #[must_use]
    pub fn spec(&self) -> &Spec {
        &self.plan.spec
    }

    /// Returns how long a takeover in a group may take from its cause, by the policies and periods that are
    /// in force now (R17). It does not allocate.
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
