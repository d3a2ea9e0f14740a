//! What runners report to the rules, and what the rules report to observers.

use std::sync::atomic::Ordering;

use jde_core::{ArbitrationReply, Check, GroupId, Health, Nanos, SchemaId, Transaction};
use jde_records::event::{Event, Loss, Occurrence, OperatorAction, What};
use jde_records::turn::{Moment, TurnKind};

use super::messages::Message;
use super::{IterationPermission, Rules, RulesState};

impl Rules {
    pub(crate) fn start(&self) {
        let ((), moment) = self.transact_recorded(|transaction| transaction.start());
        self.record_turn(TurnKind::Started, SchemaId(0), moment);
    }

    pub(crate) fn next_timer(&self) -> Option<Nanos> {
        self.state.lock().hierarchy.next_timer()
    }

    /// Reports the result of a precondition.
    pub(crate) fn report_check(&self, instance: SchemaId, check: Check) -> Moment {
        let change = |transaction: &mut Transaction| {
            transaction.checked(instance, check);
        };
        self.transact_for(instance, change).1
    }

    /// Asks the rules for permission to iterate. A schema that competes with nobody has it while it is awake, and no
    /// rule depends on its iterations: they are transactions only if somebody witnesses them.
    pub(crate) fn request_iteration(&self, instance: SchemaId) -> IterationPermission {
        match &self.free[instance] {
            Some(is_awake) => {
                self.report_waiting();
                (is_awake.load(Ordering::Acquire), Moment::default())
            }
            None => self.transact_begin(instance, None, false).1,
        }
    }

    /// Asks for permission for the first iteration since the instance became WINNER. Refused if that
    /// iteration has begun already.
    pub(crate) fn request_first_iteration(&self, instance: SchemaId) -> IterationPermission {
        self.transact_begin(instance, None, true).1
    }

    /// [`Self::report_check`], and then at once [`Self::request_iteration`] or
    /// [`Self::request_first_iteration`].
    pub(crate) fn report_check_and_request(
        &self,
        instance: SchemaId,
        check: Check,
        first: bool,
    ) -> (Moment, IterationPermission) {
        self.transact_begin(instance, Some(check), first)
    }

    /// Asks for permission to iterate before the check of the same turn. Returns when it was given.
    pub(crate) fn request_iteration_early(&self, instance: SchemaId) -> Option<Moment> {
        self.transact_begin_early(instance)
    }

    /// Whether an iteration that began before its check goes on although the precondition is false.
    pub(crate) fn should_go_on(&self, instance: SchemaId) -> bool {
        self.state.lock().hierarchy.should_go_on(instance)
    }

    /// Whether the instance became WINNER and has not begun to iterate since.
    pub(crate) fn is_taking(&self, instance: SchemaId) -> bool {
        self.state.lock().hierarchy.is_taking(instance)
    }

    /// Reports the end of an iteration.
    pub(crate) fn report_iteration_end(&self, instance: SchemaId) -> Moment {
        if self.free[instance].is_some() {
            self.report_waiting();
            return Moment::default();
        }
        self.transact_end(self.journal_of(instance), instance)
    }

    /// Reports the end of an iteration that found an input without a value (R19).
    pub(crate) fn report_iteration_end_unready(&self, instance: SchemaId) -> Moment {
        match self.free[instance] {
            Some(_) => self.report_iteration_end(instance),
            None => self.transact_end_unready(instance),
        }
    }

    /// Reports the answer of a father.
    pub(crate) fn report_arbitration(&self, group: GroupId, ticket: u64, answer: ArbitrationReply) -> Moment {
        let change = |transaction: &mut Transaction| {
            transaction.arbitrated(group, ticket, answer);
        };
        self.transact_recorded(change).1
    }

    /// Reports that a deadline was missed or met.
    pub(crate) fn report_deadline(&self, instance: SchemaId, met: bool) {
        self.transact(|transaction| {
            if met {
                transaction.on_time(instance);
            } else {
                transaction.overrun(instance);
            }
        });
    }

    /// Reports that a faulted schema has new code. It wakes up if it is requested.
    pub(crate) fn report_restored(&self, instance: SchemaId) {
        self.transact(|transaction| transaction.restored(instance));
    }

    /// Whether the schema faulted and was not restarted since.
    pub(crate) fn is_faulted(&self, instance: SchemaId) -> bool {
        matches!(self.state.lock().hierarchy.health(instance), Health::Faulted(_))
    }

    pub(super) fn notify_observers(&self, rules: &mut RulesState, event: &Event) {
        for observer in &mut rules.observers {
            observer.on_event(event);
        }
    }

    pub(super) fn report_takeover(
        &self,
        rules: &mut RulesState,
        now: Nanos,
        group: GroupId,
        record: u64,
        id: SchemaId,
        latency: Nanos,
    ) {
        let allowed = rules.groups.groups[group].allowed;
        let about = &self.application.groups[group];
        let takes_part =
            |instance: SchemaId| about.father == Some(instance) || about.members.contains(&instance);
        let cause = now.saturating_sub(latency);
        let machine = match latency > allowed {
            true => {
                let delays = self.delays.since(cause, id, takes_part);
                delays.max(self.stalls.within(cause, now))
            }
            false => 0,
        };
        let what = What::TookOver {
            group,
            record,
            schema: id,
            latency,
            allowed,
            machine,
        };
        // In a replay, lateness was reported when it first happened.
        let late = what.is_late() && !self.clock.is_replayed();
        rules.groups.record_takeover(group, record, latency, late);
        if late {
            rules.notifications.messages.push(Message::Late {
                group,
                winner: id,
                latency,
                allowed,
            });
        }
        self.notify_observers(rules, &what.at(now).into());
    }

    /// Reports an operator's action to the observers.
    pub(crate) fn report_operation(&self, by: &str, action: OperatorAction) {
        self.report_stop(by, action, Vec::new());
    }

    /// Reports an operator's action by which awake schemas lost what they read.
    pub(crate) fn report_stop(&self, by: &str, action: OperatorAction, losses: Vec<Loss>) {
        self.report_now(What::Operator {
            by: by.to_owned(),
            action,
            losses,
        });
    }

    /// Reports an event with the time at which the lock is held, so that times of events do not decrease.
    pub(crate) fn report_now(&self, what: What) {
        let mut rules = self.state.lock();
        let occurrence = what.at(self.clock.now());
        self.notify_observers(&mut rules, &occurrence.into());
    }

    /// Reports an event of a time to the observers, outside a transaction.
    pub(crate) fn report(&self, time: Nanos, what: What) {
        let mut rules = self.state.lock();
        self.notify_observers(&mut rules, &what.at(time).into());
    }

    /// Leaves an event for the next transaction to report. For publications, which do not take the rules'
    /// lock.
    pub(crate) fn report_later(&self, occurrence: Occurrence) {
        self.deferred_events.push(occurrence);
    }
}
