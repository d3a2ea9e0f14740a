//! The actions of an operator, like those of a father (R14), and their end.
//!
//! Each action is a hold of its own, and ends alone. It refuses to give authority that the fathers above do not
//! have, and to end under a lease what others stopped.

use std::sync::Arc;

use super::Phase;
use super::group::TimedCause;
use super::sleep::SleepMode;
use super::snapshot::Decision;
use super::transaction::Transaction;
use crate::record::Cause;
use crate::refused::Refused;
use crate::spec::{Kind, SchemaId};
use crate::state::{Health, Hold, HoldAction, Holder, Requester};

/// An action of an operator on a schema.
#[derive(Copy, Clone, PartialEq, Eq, Hash, Debug)]
pub enum Operator {
    /// Requests that the schema is awake, as a father would. The request ends when a father's subtree sleeps.
    /// It clears a fault. Without a lease it ends all stops of the schema; with one it is refused while somebody
    /// else stops it.
    Play(SchemaId),
    /// Puts the schema to sleep with its subtree and keeps it asleep; ends a play of the same holder.
    Stop(SchemaId),
    /// Makes the schema the choice of its group while it is awake, even if its precondition is false. The newest
    /// force counts. It ends no stop, and with a lease it is refused while somebody else stops the schema.
    Force(SchemaId),
    /// Ends what anybody holds the schema to.
    Release(SchemaId),
}

impl Transaction<'_> {
    /// Carries out an operator's action.
    ///
    /// # Errors
    /// The application is not running, the schema does not exist, a faulted or a perceptive schema is to be
    /// forced, a schema is to be played below a father that is being replaced or while it is unloaded, or a lease
    /// would end a stop of somebody else. Nothing changes then.
    pub fn operator(&mut self, by: Holder, action: Operator) -> Result<(), Refused> {
        match action {
            Operator::Play(id) => self.play(by, id),
            Operator::Stop(id) => self.stop(by, id, HoldAction::Stopped),
            Operator::Force(id) => self.force(by, id),
            Operator::Release(id) => self.end_holds(id, |_| true).map(drop),
        }?;
        self.settle();
        Ok(())
    }

    /// Stops a schema whose instance ends. Unlike [`Operator::Stop`], it keeps nothing awake that the schema needed.
    /// It takes the place of a stop of the same holder.
    ///
    /// # Errors
    /// The application is not running, or the schema does not exist. Nothing changes then.
    pub fn unload(&mut self, by: Holder, id: SchemaId) -> Result<(), Refused> {
        self.stop(by, id, HoldAction::Unloaded)?;
        self.settle();
        Ok(())
    }

    /// Ends every [`unload`](Self::unload) of a schema.
    ///
    /// # Errors
    /// As [`unload`](Self::unload).
    pub fn load(&mut self, id: SchemaId) -> Result<(), Refused> {
        self.end_holds(id, |hold| hold.action == HoldAction::Unloaded)?;
        self.settle();
        Ok(())
    }

    /// Puts every root to sleep with everything below it, and keeps it asleep. It does not wait: a schema
    /// inside an iteration loses its authority at once. Every group of roots brakes, whatever its absence
    /// policy. Before the start, it keeps every root from waking at the start.
    ///
    /// # Errors
    /// The application is shut down. Nothing changes then.
    pub fn stop_all(&mut self, by: Holder) -> Result<(), Refused> {
        if self.phase == Phase::Over {
            return Err(Refused::NotRunning);
        }
        let action = HoldAction::StoppedWithAll;
        let plan = Arc::clone(&self.plan);
        for &group in plan.root_groups() {
            if self.phase == Phase::Fresh {
                for &root in plan.members(group) {
                    self.node_mut(root).hold(Hold { by, action });
                }
                continue;
            }
            let before = self.group(group).choice();
            self.drop_handover(group);
            self.cancel_arbitration(group);
            for &root in plan.members(group) {
                self.hold_asleep(root, Hold { by, action });
                // No group selects before all roots sleep, so no root can take over in between.
                self.withdraw(root);
                self.drain(root, SleepMode::AtOnce);
                if self.is_awake(root) {
                    self.put_to_sleep(root);
                }
            }
            self.group_mut(group).lose(before);
            if let Some(first) = before.or_else(|| plan.members(group).first().copied()) {
                let trigger = TimedCause::new(Cause::Operator(first), self.now);
                let list = self.candidates_of(group);
                self.decide(group, list, Decision::all_stopped(), trigger);
            }
            self.brake(group);
        }
        self.settle();
        Ok(())
    }

    /// Ends every [`stop_all`](Self::stop_all), and no other hold. Returns the roots that no operator keeps asleep
    /// any more.
    ///
    /// # Errors
    /// The application is not running. Nothing changes then.
    pub fn release_all(&mut self) -> Result<Vec<SchemaId>, Refused> {
        if self.phase != Phase::Running {
            return Err(Refused::NotRunning);
        }
        let plan = Arc::clone(&self.plan);
        let roots = plan.root_groups().iter().flat_map(|group| plan.members(*group));
        let mut released = Vec::new();
        for &root in roots {
            let ended = self.end_holds(root, |hold| hold.action == HoldAction::StoppedWithAll)?;
            if ended && !self.is_stopped(root) {
                released.push(root);
            }
        }
        self.settle();
        Ok(released)
    }

    /// Ends what one holder holds a schema to: the end of a lease. Of an operator without a lease, that includes
    /// what is held under a lease of the same operator. A stop of all schemas stays. Returns whether anything ended.
    ///
    /// # Errors
    /// The application is not running, or the schema does not exist. Nothing changes then.
    pub fn let_go(&mut self, by: Holder, id: SchemaId) -> Result<bool, Refused> {
        let is_theirs = |holder: Holder| holder.operator == by.operator && (holder.leased || !by.leased);
        let ended = self.end_holds(id, |hold| {
            is_theirs(hold.by) && hold.action != HoldAction::StoppedWithAll
        })?;
        self.settle();
        Ok(ended)
    }

    fn play(&mut self, by: Holder, id: SchemaId) -> Result<(), Refused> {
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
        if self.node(id).holds().contains(HoldAction::Unloaded) {
            return Err(Refused::Unloaded {
                schema: self.name(id),
            });
        }
        self.check_stops_of_others(by, id)?;
        if self.node(id).is_faulted() {
            self.forget_faults(id);
            self.set_health(id, Health::Ok);
        }
        let action = HoldAction::Played;
        let node = self.node_mut(id);
        node.end_holds(|hold| hold.action.stops());
        node.hold(Hold { by, action });
        self.release_unheld(id);
        let woke = self.request(id, Requester::Operator);
        self.compete(id, woke, Cause::Operator(id));
        Ok(())
    }

    /// Keeps a schema asleep by this action, until the hold ends.
    fn stop(&mut self, by: Holder, id: SchemaId, action: HoldAction) -> Result<(), Refused> {
        self.running_and_known(id)?;
        let unloads = action == HoldAction::Unloaded;
        let unloaded = Hold {
            by,
            action: HoldAction::Unloaded,
        };
        if !self.node(id).holds().iter().any(|hold| hold == unloaded) {
            self.node_mut(id).end_holds(|hold| match hold.action {
                HoldAction::Played => hold.by == by,
                HoldAction::Stopped => unloads && hold.by == by,
                HoldAction::Unloaded | HoldAction::StoppedWithAll | HoldAction::Forced => false,
            });
            self.hold_asleep(id, Hold { by, action });
        }
        self.release_unheld(id);
        self.sleep_if_unneeded(id, Cause::Operator(id));
        Ok(())
    }

    /// Adds a stop. Unless the schema is unloaded, all that it and the schemas below it need at this instant to see
    /// stays awake until no operator stops it (R6).
    fn hold_asleep(&mut self, id: SchemaId, stop: Hold) {
        self.node_mut(id).hold(stop);
        if !self.node(id).holds().keep_needs() || stop.by == Holder::UNKNOWN {
            return;
        }
        let plan = Arc::clone(&self.plan);
        for user in self.subtree(id).into_iter().chain([id]) {
            if self.is_awake(user) {
                let spec = plan.schema(user);
                for need in [&spec.needs, self.node(user).woken()].concat() {
                    if !spec.only_commands.contains(&need) {
                        self.request(need, Requester::Stopped(id));
                    }
                }
            }
        }
    }

    fn force(&mut self, by: Holder, id: SchemaId) -> Result<(), Refused> {
        self.running_and_known(id)?;
        self.not_faulted(id)?;
        let Some(group) = self.plan.group_of(id) else {
            return Err(Refused::NotMotor {
                schema: self.name(id),
            });
        };
        self.check_stops_of_others(by, id)?;
        self.group_mut(group).force(by, id);
        if self.is_live(group) {
            self.select(group, TimedCause::new(Cause::Operator(id), self.now));
        }
        Ok(())
    }

    /// Refuses a lease what would end a stop of others, or have no effect while it lasts.
    fn check_stops_of_others(&self, by: Holder, id: SchemaId) -> Result<(), Refused> {
        match self.node(id).holds().stop_of_another(by).filter(|_| by.leased) {
            Some(stop) => Err(Refused::HeldStopped {
                schema: self.name(id),
                stop,
            }),
            None => Ok(()),
        }
    }

    /// Ends holds on a schema, and what followed from them alone. Returns whether there were any.
    fn end_holds(&mut self, id: SchemaId, which: impl Fn(Hold) -> bool) -> Result<bool, Refused> {
        self.running_and_known(id)?;
        let was_stopped = self.is_stopped(id);
        let held = self.node_mut(id).end_holds(&which);
        let action = HoldAction::Forced;
        let forced = self.plan.group_of(id).is_some_and(|group| {
            self.group_mut(group)
                .end_forces(|by, forced| forced == id && which(Hold { by, action }))
        });
        self.release_unheld(id);
        let woke = was_stopped && self.wake_if_allowed(id);
        if self.node(id).should_be_awake() {
            if woke || was_stopped || forced {
                self.compete_again(id);
            }
        } else {
            self.sleep_if_unneeded(id, Cause::Operator(id));
        }
        Ok(held || forced)
    }

    /// Removes the requests for which no hold on a schema is left.
    fn release_unheld(&mut self, id: SchemaId) {
        let plan = Arc::clone(&self.plan);
        let holds = self.node(id).holds();
        let (is_played, keeps_needs) = (holds.contains(HoldAction::Played), holds.keep_needs());
        if !is_played {
            self.release(id, Requester::Operator);
        }
        if !keeps_needs {
            for need in plan.ids_of(Kind::Perceptive) {
                self.release(need, Requester::Stopped(id));
            }
        }
    }

    fn compete_again(&mut self, id: SchemaId) {
        if let Some(group) = self.plan.group_of(id)
            && self.is_awake(id)
        {
            self.select(group, TimedCause::new(Cause::Operator(id), self.now));
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
