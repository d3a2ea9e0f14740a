//! Waking and putting to sleep at a father's wish (R6, R7).
//!
//! It refuses every father that does not hold authority, and every child that is not its own.

use std::sync::Arc;

use super::Hierarchy;
use super::parts::Phase;
use super::selection::Why;
use super::sleep::Pace;
use crate::effect::Effect;
use crate::record::Cause;
use crate::refused::Refused;
use crate::spec::{Kind, Nanos, SchemaId};
use crate::state::{Requester, State};

impl Hierarchy {
    /// Wakes a motor child of one of the father's groups, or a perceptive schema; without effect if the father woke
    /// it already. A faulted child wakes when its restart policy allows.
    ///
    /// # Errors
    /// The father has no authority (R7) or is losing it, it is not its child, or an operator stopped the child. In the
    /// last case the wish is kept, and counts when the operator lets go.
    pub fn wake(
        &mut self,
        now: Nanos,
        father: SchemaId,
        child: SchemaId,
        out: &mut Vec<Effect>,
    ) -> Result<(), Refused> {
        self.may_lead(father, child)?;
        let who = Requester::Father(father);
        if self.node(child).requesters.binary_search(&who).is_err() {
            if self.plan.kind(child) == Kind::Perceptive {
                self.node_mut(father).woke.push(child);
            }
            let awake = self.request(child, who, out);
            self.compete(now, child, awake, Cause::Woken(child), out);
            self.settle(out);
        }
        if self.node(child).is_stopped() {
            Err(Refused::Stopped {
                schema: self.name(child),
            })
        } else {
            Ok(())
        }
    }

    /// Takes back what [`wake`](Self::wake) did: a motor child sleeps with its subtree, as soon as its iteration has
    /// ended; a perceptive schema once nobody else needs it. Without effect if the father did not wake it.
    ///
    /// # Errors
    /// The father has no authority (R7) or is losing it, or it is not its child.
    pub fn sleep(
        &mut self,
        now: Nanos,
        father: SchemaId,
        child: SchemaId,
        out: &mut Vec<Effect>,
    ) -> Result<(), Refused> {
        self.may_lead(father, child)?;
        if self.release(child, Requester::Father(father)) {
            self.node_mut(father).woke.retain(|&w| w != child);
            self.let_sleep(now, child, Cause::Slept(child), out);
        }
        self.settle(out);
        Ok(())
    }

    /// One requester more; wakes the schema if that is allowed. True if it woke.
    pub(super) fn request(&mut self, id: SchemaId, who: Requester, out: &mut Vec<Effect>) -> bool {
        let requesters = &mut self.node_mut(id).requesters;
        if let Err(at) = requesters.binary_search(&who) {
            requesters.insert(at, who);
        }
        self.rise(id, out)
    }

    /// Wakes a schema that is wanted and sleeps, after all it needs. True if it woke.
    pub(super) fn rise(&mut self, id: SchemaId, out: &mut Vec<Effect>) -> bool {
        if self.phase != Phase::Running || self.is_awake(id) || !self.node(id).wanted() {
            return false;
        }
        let plan = Arc::clone(&self.plan);
        for &need in &plan.schema(id).needs {
            self.request(need, Requester::Need(id), out);
        }
        out.push(Effect::Woken(id));
        let state = match plan.kind(id) {
            Kind::Perceptive => State::Winner,
            Kind::Motor => State::Checking,
        };
        self.change(id, state, out);
        true
    }

    /// After a requester was added: a motor schema that woke, or that was about to be put to sleep as a winner,
    /// competes.
    pub(super) fn compete(
        &mut self,
        now: Nanos,
        id: SchemaId,
        woke: bool,
        cause: Cause,
        out: &mut Vec<Effect>,
    ) {
        if let Some(group) = self.plan.group_of(id)
            && (woke || self.node(id).state == State::Winner)
        {
            self.select(now, group, Why::new(cause, now), out);
        }
    }

    /// After a reason to be awake was taken away: a motor schema without any left leaves its group. A winner does so
    /// by a handover, any other at once.
    pub(super) fn let_sleep(&mut self, now: Nanos, id: SchemaId, cause: Cause, out: &mut Vec<Effect>) {
        if self.node(id).wanted() || !self.is_awake(id) {
            return;
        }
        let Some(group) = self.plan.group_of(id) else {
            return self.lay_down(id, out);
        };
        if self.node(id).state != State::Winner {
            let before = self.group(group).choice();
            self.drain(id, Pace::AtOnce, out);
            self.lay_down(id, out);
            self.group_mut(group).lose(before);
        }
        self.select(now, group, Why::new(cause, now), out);
    }

    fn may_lead(&self, father: SchemaId, child: SchemaId) -> Result<(), Refused> {
        self.running_and_known(father)?;
        self.running_and_known(child)?;
        if self.plan.kind(child) == Kind::Motor && self.plan.father(child) != Some(father) {
            return Err(Refused::NotChild {
                father: self.name(father),
                child: self.name(child),
            });
        }
        if !self.node(father).authority {
            let mut because = father;
            while self.state(because) == State::Winner
                && let Some(above) = self.plan.father(because)
            {
                because = above;
            }
            return Err(Refused::NoAuthority {
                father: self.name(father),
                because: self.name(because),
            });
        }
        if self.leaving(father).is_some() {
            return Err(Refused::Leaving {
                schema: self.name(father),
            });
        }
        Ok(())
    }
}
