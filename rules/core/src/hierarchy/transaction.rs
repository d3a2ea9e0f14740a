//! One change of a hierarchy at one instant, with the effects that it has.
//!
//! It reads as the hierarchy that it changes.

use std::ops::{Deref, DerefMut};
use std::sync::Arc;

use super::group::TimedCause;
use super::sleep::SleepMode;
use super::{Hierarchy, Phase};
use crate::effect::Effect;
use crate::policy::Policy;
use crate::record::Cause;
use crate::spec::{GroupId, Kind, Nanos, SchemaId};
use crate::spec_error::SpecError;
use crate::state::{Requester, State};
use crate::validate::policy_fault;

/// Changes a hierarchy; made by [`Hierarchy::at`]. Its methods are the reports of the executor, and the requests
/// of fathers and operators.
#[derive(Debug)]
pub struct Transaction<'a> {
    pub(super) hierarchy: &'a mut Hierarchy,
    pub(super) now: Nanos,
    pub(super) out: &'a mut Vec<Effect>,
}

impl Hierarchy {
    /// Begins a transaction at `now`, whose effects are appended to `out`.
    #[inline]
    pub fn at<'a>(&'a mut self, now: Nanos, out: &'a mut Vec<Effect>) -> Transaction<'a> {
        Transaction {
            hierarchy: self,
            now,
            out,
        }
    }
}

impl Deref for Transaction<'_> {
    type Target = Hierarchy;

    #[inline]
    fn deref(&self) -> &Hierarchy {
        self.hierarchy
    }
}

impl DerefMut for Transaction<'_> {
    #[inline]
    fn deref_mut(&mut self) -> &mut Hierarchy {
        self.hierarchy
    }
}

impl Transaction<'_> {
    /// Returns its time.
    #[must_use]
    pub fn now(&self) -> Nanos {
        self.now
    }

    /// Returns whether it has had an effect so far, or `out` was not empty when it began.
    #[must_use]
    pub fn has_effects(&self) -> bool {
        !self.out.is_empty()
    }

    /// Wakes the roots (R13). A second call has no effect.
    pub fn start(&mut self) {
        if self.phase != Phase::Fresh {
            return;
        }
        self.phase = Phase::Running;
        let plan = Arc::clone(&self.plan);
        for &group in plan.root_groups() {
            for &root in plan.members(group) {
                self.request(root, Requester::Application);
            }
            self.select(group, TimedCause::new(Cause::Start, self.now));
        }
    }

    /// Ends the application: authority is withdrawn, every group brakes, and all schemas go to sleep,
    /// children before fathers and perceptive schemas last. No schema wakes afterwards.
    pub fn shutdown(&mut self) {
        if self.phase != Phase::Running {
            self.phase = Phase::Over;
            return;
        }
        self.phase = Phase::Over;
        let plan = Arc::clone(&self.plan);
        for &group in plan.root_groups() {
            if let Some(winner) = self.group(group).winner() {
                self.withdraw(winner);
            }
        }
        self.out
            .extend(plan.group_ids().map(|group| Effect::Brake { group }));
        for &group in plan.root_groups() {
            self.sleep_group(group, SleepMode::AtOnce);
        }
        for id in plan.ids_of(Kind::Perceptive) {
            for requester in self.requesters(id).to_vec() {
                match requester {
                    Requester::Application | Requester::Operator | Requester::Stopped(_) => {
                        self.release(id, requester);
                    }
                    // It ends when the schema that requests it sleeps.
                    Requester::Father(_) | Requester::Need(_) => {}
                }
            }
        }
        self.settle();
        self.timers.clear();
    }

    /// Changes the policy of a group on behalf of its father. The group selects at once (R2). An open
    /// request to the father is dropped. An unknown group has no effect.
    ///
    /// # Errors
    /// A policy that this group cannot have; nothing changes then.
    pub fn set_policy(&mut self, group: GroupId, policy: Policy) -> Result<(), SpecError> {
        let Some(spec) = self.plan.spec.groups.get(group) else {
            return Ok(());
        };
        if let Some(fault) = policy_fault(spec, policy) {
            return Err(fault);
        }
        if spec.policy != policy {
            Arc::make_mut(&mut self.plan).spec.groups[group].policy = policy;
            self.cancel_arbitration(group);
            if self.is_live(group) {
                self.select(group, TimedCause::new(Cause::PolicyChanged, self.now));
            }
            self.settle();
        }
        Ok(())
    }

    pub(super) fn change(&mut self, id: SchemaId, to: State) {
        let from = self.node_mut(id).set_state(to);
        if from != to {
            self.out.push(Effect::Changed { id, from, to });
        }
    }
}
