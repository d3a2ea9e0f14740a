//! The actions of an operator, like those of a father (R14), and their reversal.
//!
//! It refuses to give authority that the fathers above do not have.

use std::sync::Arc;

use super::group::TimedCause;
use super::sleep::SleepMode;
use super::snapshot::Decision;
use super::{Hierarchy, Phase};
use crate::effect::Effect;
use crate::record::Cause;
use crate::refused::Refused;
use crate::spec::{Nanos, SchemaId};
use crate::state::{Health, Requester};

/// An action of an operator on a schema.
#[derive(Copy, Clone, PartialEq, Eq, Hash, Debug)]
pub enum Operator {
    /// Requests that the schema is awake, as a father would. The request ends when a father's subtree sleeps.
    /// It reverses a stop and clears a fault.
    Play(SchemaId),
    /// Puts the schema to sleep with its subtree and keeps it asleep; reverses a play.
    Stop(SchemaId),
    /// Makes the schema the choice of its group while it is awake, even if its precondition is false. It
    /// replaces a force on a sibling.
    Force(SchemaId),
    /// Reverses all of the above for the schema.
    Release(SchemaId),
}

impl Hierarchy {
    /// Carries out an operator's action.
    ///
    /// # Errors
    /// The application is not running, the schema does not exist, a faulted or a perceptive schema is to be
    /// forced, or a schema is to be played below a father that is being replaced. Nothing changes then.
    pub fn operator(&mut self, now: Nanos, action: Operator, out: &mut Vec<Effect>) -> Result<(), Refused> {
        match action {
            Operator::Play(id) => self.play(now, id, out),
            Operator::Stop(id) => self.stop(now, id, out),
            Operator::Force(id) => self.force(now, id, out),
            Operator::Release(id) => self.undo(now, id, true, out),
        }?;
        self.settle(out);
        Ok(())
    }

    /// Puts every root to sleep with everything below it, and keeps it asleep. It does not wait: a schema
    /// inside an iteration loses its authority at once. Every group of roots brakes, whatever its absence
    /// policy. Before the start, it keeps every root from waking at the start.
    ///
    /// # Errors
    /// The application is shut down. Nothing changes then.
    pub fn stop_all(&mut self, now: Nanos, out: &mut Vec<Effect>) -> Result<(), Refused> {
        if self.phase == Phase::Over {
            return Err(Refused::NotRunning);
        }
        let plan = Arc::clone(&self.plan);
        for &group in plan.root_groups() {
            if self.phase == Phase::Fresh {
                for &root in plan.members(group) {
                    self.node_mut(root).stop_with_all();
                }
                continue;
            }
            let before = self.group(group).choice();
            self.drop_handover(group);
            self.cancel_arbitration(group);
            for &root in plan.members(group) {
                self.node_mut(root).stop_with_all();
                // No group selects before all roots sleep, so no root can take over in between.
                self.withdraw(root, out);
                self.drain(root, SleepMode::AtOnce, out);
                if self.is_awake(root) {
                    self.put_to_sleep(root, out);
                }
            }
            self.group_mut(group).lose(before);
            if let Some(first) = before.or_else(|| plan.members(group).first().copied()) {
                let trigger = TimedCause::new(Cause::Operator(first), now);
                let list = self.candidates_of(group);
                self.decide(now, group, list, Decision::all_stopped(), trigger, out);
            }
            self.brake(group, out);
        }
        self.settle(out);
        Ok(())
    }

    /// Reverses [`stop_all`](Self::stop_all), and no other action of an operator. Returns the roots that no
    /// operator keeps asleep any more.
    ///
    /// # Errors
    /// The application is not running. Nothing changes then.
    pub fn release_all(&mut self, now: Nanos, out: &mut Vec<Effect>) -> Result<Vec<SchemaId>, Refused> {
        if self.phase != Phase::Running {
            return Err(Refused::NotRunning);
        }
        let plan = Arc::clone(&self.plan);
        let roots = plan.root_groups().iter().flat_map(|group| plan.members(*group));
        let mut released = Vec::new();
        for &root in roots {
            let stopped = self.node_mut(root).undo_stop_with_all();
            if stopped && !self.node(root).is_stopped() {
                released.push(root);
                if self.wake_if_allowed(root, out) {
                    self.compete_again(now, root, out);
                }
            }
        }
        self.settle(out);
        Ok(released)
    }

    /// Reverses the actions on this schema alone. Unlike [`Operator::Release`], it keeps a schema stopped
    /// that was stopped with all others.
    ///
    /// # Errors
    /// The application is not running, or the schema does not exist. Nothing changes then.
    pub fn let_go(&mut self, now: Nanos, id: SchemaId, out: &mut Vec<Effect>) -> Result<(), Refused> {
        self.undo(now, id, false, out)?;
        self.settle(out);
        Ok(())
    }

    fn play(&mut self, now: Nanos, id: SchemaId, out: &mut Vec<Effect>) -> Result<(), Refused> {
        self.running_and_known(id)?;
        if self
            .plan
            .father(id)
            .is_some_and(|father| self.handover_above(father).is_some())
        {
            return Err(Refused::BeingReplaced {
                schema: self.name(id),
            });
        }
        if self.node(id).is_faulted() {
            self.forget_faults(id);
            self.set_health(id, Health::Ok, out);
        }
        let node = self.node_mut(id);
        node.undo_stop();
        node.undo_stop_with_all();
        let woke = self.request(id, Requester::Operator, out);
        self.compete(now, id, woke, Cause::Operator(id), out);
        Ok(())
    }

    fn stop(&mut self, now: Nanos, id: SchemaId, out: &mut Vec<Effect>) -> Result<(), Refused> {
        self.running_and_known(id)?;
        self.node_mut(id).stop();
        self.release(id, Requester::Operator);
        self.sleep_if_unneeded(now, id, Cause::Operator(id), out);
        Ok(())
    }

    fn force(&mut self, now: Nanos, id: SchemaId, out: &mut Vec<Effect>) -> Result<(), Refused> {
        self.running_and_known(id)?;
        self.not_faulted(id)?;
        let Some(group) = self.plan.group_of(id) else {
            return Err(Refused::NotMotor {
                schema: self.name(id),
            });
        };
        self.group_mut(group).force(id);
        if self.is_live(group) {
            self.select(now, group, TimedCause::new(Cause::Operator(id), now), out);
        }
        Ok(())
    }

    fn undo(
        &mut self,
        now: Nanos,
        id: SchemaId,
        with_all: bool,
        out: &mut Vec<Effect>,
    ) -> Result<(), Refused> {
        self.running_and_known(id)?;
        let node = self.node_mut(id);
        let stopped = node.undo_stop() | (with_all && node.undo_stop_with_all());
        self.release(id, Requester::Operator);
        let group = self.plan.group_of(id);
        let forced = group.is_some_and(|g| self.group_mut(g).undo_force(id));
        let woke = stopped && self.wake_if_allowed(id, out);
        if self.node(id).should_be_awake() {
            if woke || stopped || forced {
                self.compete_again(now, id, out);
            }
        } else {
            self.sleep_if_unneeded(now, id, Cause::Operator(id), out);
        }
        Ok(())
    }

    fn compete_again(&mut self, now: Nanos, id: SchemaId, out: &mut Vec<Effect>) {
        if let Some(group) = self.plan.group_of(id)
            && self.is_awake(id)
        {
            self.select(now, group, TimedCause::new(Cause::Operator(id), now), out);
        }
    }

    fn not_faulted(&self, id: SchemaId) -> Result<(), Refused> {
        match self.health(id) {
            Health::Faulted(reason) => Err(Refused::Faulted {
                schema: self.name(id),
                reason: reason.clone(),
            }),
            Health::Ok | Health::Overrun | Health::ArbitrationFailed(_) => Ok(()),
        }
    }
}
