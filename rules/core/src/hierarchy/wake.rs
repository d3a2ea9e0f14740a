//! Waking and putting to sleep at the request of a father (R6, R7).
//!
//! It refuses a father that does not hold authority, and a child of another father.

use std::sync::Arc;

use super::Phase;
use super::group::TimedCause;
use super::sleep::SleepMode;
use super::transaction::Transaction;
use crate::effect::Effect;
use crate::record::Cause;
use crate::refused::Refused;
use crate::spec::{Kind, SchemaId};
use crate::state::{Requester, State};

impl Transaction<'_> {
    /// Wakes a motor child of one of the father's groups, or a perceptive schema. Has no effect if the father
    /// woke it already. A faulted child wakes when its restart policy allows.
    ///
    /// # Errors
    /// The father has no authority (R7) or is being replaced, the child is not its own, or an operator
    /// stopped the child. In the last case the request is kept and takes effect when the operator releases
    /// the child.
    pub fn wake(&mut self, father: SchemaId, child: SchemaId) -> Result<(), Refused> {
        self.check_authority(father, child)?;
        let requester = Requester::Father(father);
        if !self.node(child).is_requested_by(requester) {
            if self.plan.kind(child) == Kind::Perceptive {
                self.node_mut(father).add_woken(child);
            }
            let awake = self.request(child, requester);
            self.compete(child, awake, Cause::Woken(child));
            self.settle();
        }
        if self.node(child).is_stopped() {
            Err(Refused::Stopped {
                schema: self.name(child),
            })
        } else {
            Ok(())
        }
    }

    /// Reverses [`wake`](Self::wake): a motor child sleeps with its subtree as soon as its iteration has
    /// ended, a perceptive schema as soon as it has no other requester. Has no effect if the father did not
    /// wake it.
    ///
    /// # Errors
    /// The father has no authority (R7) or is being replaced, or the child is not its own.
    pub fn sleep(&mut self, father: SchemaId, child: SchemaId) -> Result<(), Refused> {
        self.check_authority(father, child)?;
        if self.release(child, Requester::Father(father)) {
            self.node_mut(father).remove_woken(child);
            self.sleep_if_unneeded(child, Cause::Slept(child));
        }
        self.settle();
        Ok(())
    }

    /// Adds a requester and wakes the schema if that is allowed. Returns true if it woke.
    pub(super) fn request(&mut self, id: SchemaId, requester: Requester) -> bool {
        self.node_mut(id).request(requester);
        self.wake_if_allowed(id)
    }

    /// Wakes a schema that sleeps and should be awake, after all schemas that it needs. Returns true if it
    /// woke.
    pub(super) fn wake_if_allowed(&mut self, id: SchemaId) -> bool {
        if self.phase != Phase::Running || self.is_awake(id) || !self.node(id).should_be_awake() {
            return false;
        }
        let plan = Arc::clone(&self.plan);
        for &need in &plan.schema(id).needs {
            self.request(need, Requester::Need(id));
        }
        self.out.push(Effect::Woken(id));
        let state = match plan.kind(id) {
            Kind::Perceptive => State::Winner,
            Kind::Motor => State::Checking,
        };
        self.change(id, state);
        true
    }

    /// Lets a motor schema compete after a requester was added, if it woke or is a winner that was about to
    /// sleep.
    pub(super) fn compete(&mut self, id: SchemaId, woke: bool, cause: Cause) {
        if let Some(group) = self.plan.group_of(id)
            && (woke || self.node(id).state() == State::Winner)
        {
            self.select(group, TimedCause::new(cause, self.now));
        }
    }

    /// Removes a motor schema without a reason to be awake from its group. A winner leaves by a handover, any
    /// other schema at once.
    pub(super) fn sleep_if_unneeded(&mut self, id: SchemaId, cause: Cause) {
        if self.node(id).should_be_awake() || !self.is_awake(id) {
            return;
        }
        let Some(group) = self.plan.group_of(id) else {
            return self.put_to_sleep(id);
        };
        if self.node(id).state() != State::Winner {
            let before = self.group(group).choice();
            self.drain(id, SleepMode::AtOnce);
            self.put_to_sleep(id);
            self.group_mut(group).lose(before);
        }
        self.select(group, TimedCause::new(cause, self.now));
    }

    fn check_authority(&self, father: SchemaId, child: SchemaId) -> Result<(), Refused> {
        self.running_and_known(father)?;
        self.running_and_known(child)?;
        if self.plan.kind(child) == Kind::Motor && self.plan.father(child) != Some(father) {
            return Err(Refused::NotChild {
                father: self.name(father),
                child: self.name(child),
            });
        }
        if !self.node(father).has_authority() {
            let mut blocker = father;
            while self.state(blocker) == State::Winner
                && let Some(father) = self.plan.father(blocker)
            {
                blocker = father;
            }
            return Err(Refused::NoAuthority {
                father: self.name(father),
                because: self.name(blocker),
            });
        }
        if self.handover_above(father).is_some() {
            return Err(Refused::BeingReplaced {
                schema: self.name(father),
            });
        }
        Ok(())
    }
}
