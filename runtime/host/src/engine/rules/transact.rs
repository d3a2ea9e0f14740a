//! One transaction of the rules: the change, its effects carried out in order, and the events for observers.

use std::sync::Arc;
use std::sync::atomic::Ordering;

use jde_abi::describe::Kind;
use jde_board::Variable;
use jde_core::{Check, Effect, Nanos, SchemaId, State, Transaction};
use jde_records::event::{Event, StateChange, What};
use jde_records::turn::{Moment, Turn, TurnKind};

use super::messages::Message;
use super::{Rules, RulesState, Signal, subtree_with};
use crate::journal::Journal;
use crate::transaction_observer::{ObservedTransaction, TransactionInput};

/// Whether permission to iterate was given, and when it was asked for.
pub(crate) type IterationPermission = (bool, Moment);

impl Rules {
    /// Runs `change` and carries out all its effects in order, before any other change.
    pub(crate) fn transact<R>(&self, change: impl FnOnce(&mut Transaction) -> R) -> R {
        self.transact_as(None, |_| TransactionInput::Other, change).0
    }

    /// Like [`Self::transact`], with a moment for the turns only if the change has effects. For changes that
    /// schemas request often.
    pub(crate) fn transact_if_any<R>(&self, change: impl FnOnce(&mut Transaction) -> R) -> (R, Moment) {
        let mut moment = Moment::default();
        let result = self.transact(|transaction| {
            let result = change(transaction);
            moment = self.moment_if_any(transaction);
            result
        });
        (result, moment)
    }

    /// The moment of a transaction for the turns, if it has effects so far.
    fn moment_if_any(&self, transaction: &Transaction) -> Moment {
        let journal = self.journal.as_deref().filter(|_| transaction.has_effects());
        journal.map_or_else(Moment::default, |journal| Moment {
            order: journal.next(),
            time: transaction.now(),
        })
    }

    /// Like [`Self::transact`], with a moment for the turns.
    pub(crate) fn transact_recorded<R>(&self, change: impl FnOnce(&mut Transaction) -> R) -> (R, Moment) {
        self.transact_as(self.journal.as_deref(), |_| TransactionInput::Other, change)
    }

    /// Like [`Self::transact_recorded`], in a turn of an instance. The turns of drivers are not recorded: their
    /// exports show the results.
    pub(crate) fn transact_for<R>(
        &self,
        instance: SchemaId,
        change: impl FnOnce(&mut Transaction) -> R,
    ) -> (R, Moment) {
        self.transact_as(self.journal_of(instance), |_| TransactionInput::Other, change)
    }

    /// Reports the result of a precondition, if there is one, and then asks for permission to iterate. With
    /// `first` it asks only for the first iteration since the instance became WINNER; that is refused if it
    /// has begun already. Returns when each was, and the permission.
    pub(super) fn transact_begin(
        &self,
        instance: SchemaId,
        check: Option<Check>,
        first: bool,
    ) -> (Moment, IterationPermission) {
        let journal = self.journal_of(instance);
        let mut rules = self.state.lock();
        let checked = check.map_or_else(Moment::default, |check| {
            let change = |transaction: &mut Transaction| {
                transaction.checked(instance, check);
            };
            self.transact_within(&mut rules, journal, |()| TransactionInput::Other, change)
                .1
        });
        let step = |may: &bool| {
            if *may {
                TransactionInput::IterationBegan(instance)
            } else {
                TransactionInput::Other
            }
        };
        let begun = self.transact_within(&mut rules, journal, step, |transaction| {
            (!first || transaction.is_taking(instance)) && transaction.begin(instance)
        });
        self.unlock(rules);
        (checked, begun)
    }

    /// Begins an iteration before the check of its turn, if the rules permit it. Returns when.
    pub(crate) fn transact_begin_early(&self, instance: SchemaId) -> Option<Moment> {
        if !self.read(|rules| rules.hierarchy.may_begin_early(instance)) {
            return None;
        }
        let step = |may: &bool| match may {
            true => TransactionInput::IterationBegan(instance),
            false => TransactionInput::Other,
        };
        let begin = |transaction: &mut Transaction| {
            transaction.may_begin_early(instance) && transaction.begin(instance)
        };
        let (may, moment) = self.transact_as(self.journal_of(instance), step, begin);
        may.then_some(moment)
    }

    /// Reports that the iteration of an instance ended, or that the host no longer waits for it.
    pub(crate) fn transact_end(&self, journal: Option<&Journal>, instance: SchemaId) -> Moment {
        self.transact_as(
            journal,
            |()| TransactionInput::IterationEnded(instance),
            |transaction| {
                transaction.end(instance);
            },
        )
        .1
    }

    /// Reports that the iteration of an instance found an input without a value (R19). If the instance stays WINNER,
    /// what it commands is neutral from then on.
    pub(super) fn transact_end_unready(&self, instance: SchemaId) -> Moment {
        let mut rules = self.state.lock();
        let moment = self
            .transact_within(
                &mut rules,
                self.journal_of(instance),
                |()| TransactionInput::IterationEnded(instance),
                |transaction| transaction.end_unready(instance),
            )
            .1;
        if rules.hierarchy.has_authority(instance) {
            let drivers = rules.commands.brake(&[instance], self.clock.now());
            self.signal_drivers(&mut rules, &drivers);
        }
        self.unlock(rules);
        moment
    }

    /// Ends the application: puts every schema to sleep.
    pub(super) fn transact_shutdown(&self) -> Moment {
        let change = |transaction: &mut Transaction| transaction.shutdown();
        self.transact_as(self.journal.as_deref(), |()| TransactionInput::Shutdown, change)
            .1
    }

    /// Reports that a guard refused a command of an instance, in these words (R18). If it was in force, and no other
    /// was given since, it is neutral from now on. Returns a moment only if that had effects and turns are recorded.
    pub(crate) fn transact_refusal(
        &self,
        instance: SchemaId,
        words: String,
        in_force: Option<&(Arc<Variable>, u64)>,
    ) -> Moment {
        let mut rules = self.state.lock();
        if let Some((variable, sequence)) = in_force {
            let drivers = rules.commands.end_refused(variable, *sequence, self.clock.now());
            self.signal_drivers(&mut rules, &drivers);
        }
        rules.refusal = Some(words);
        let mut moment = Moment::default();
        let change = |transaction: &mut Transaction| {
            transaction.refused(instance);
            moment = self.moment_if_any(transaction);
        };
        self.transact_within(&mut rules, None, |()| TransactionInput::Other, change);
        rules.refusal = None;
        self.unlock(rules);
        moment
    }

    /// Replaces a command in force by the one to which a guard limits it (R18), unless another was given since.
    pub(crate) fn limit_in_force(&self, variable: &Arc<Variable>, sequence: u64, limited: &[u8]) {
        let mut rules = self.state.lock();
        let drivers = rules.commands.limit(variable, sequence, limited);
        self.signal_drivers(&mut rules, &drivers);
        self.unlock(rules);
    }

    /// The journal for an instance's turns; `None` for drivers.
    pub(crate) fn journal_of(&self, instance: SchemaId) -> Option<&Journal> {
        let is_driver = self.application.instances[instance].schema.kind == Kind::Driver;
        self.journal.as_deref().filter(|_| !is_driver)
    }

    fn transact_as<R>(
        &self,
        journal: Option<&Journal>,
        step: impl FnOnce(&R) -> TransactionInput,
        change: impl FnOnce(&mut Transaction) -> R,
    ) -> (R, Moment) {
        let mut rules = self.state.lock();
        let done = self.transact_within(&mut rules, journal, step, change);
        self.unlock(rules);
        done
    }

    /// Runs one of several consecutive transactions under one lock, with no other transaction between them.
    pub(super) fn transact_within<R>(
        &self,
        rules: &mut RulesState,
        journal: Option<&Journal>,
        step: impl FnOnce(&R) -> TransactionInput,
        change: impl FnOnce(&mut Transaction) -> R,
    ) -> (R, Moment) {
        let now = self.clock.now();
        let order = journal.map_or(0, Journal::next);
        let time = if order > 0 { now } else { 0 };
        let moment = Moment { order, time };
        if !self.deferred_events.is_empty() {
            for event in self.deferred_events.take() {
                self.notify_observers(rules, &event.into());
            }
        }
        if rules.groups.is_any_chattering() {
            for calmed in rules.groups.advance(now) {
                self.notify_observers(rules, &calmed.into());
            }
            self.note_chattering(rules);
        }
        // A change that panicked may have left effects behind.
        rules.effects.clear();
        let result = change(&mut rules.hierarchy.at(now, &mut rules.effects));
        // Most checks and permissions have no effects.
        if !rules.effects.is_empty() || rules.transaction_observer.is_some() {
            self.carry_out(rules, now, step(&result));
        }
        let next = rules.hierarchy.next_timer();
        if rules.alarm != next && self.signals.set_timer_within(&mut rules.notifications, next) {
            rules.alarm = next;
        }
        (result, moment)
    }

    /// Carries out the effects of a transaction, and shows them to the transaction observer.
    fn carry_out(&self, rules: &mut RulesState, now: Nanos, step: TransactionInput) {
        let mut effects = std::mem::take(&mut rules.effects);
        // A copy, because carrying out consumes the effects.
        let witnessed = rules.transaction_observer.is_some().then(|| effects.clone());
        for effect in effects.drain(..) {
            self.apply(rules, now, effect);
        }
        if let Some(effects) = witnessed {
            self.notify_transaction_observer(rules, now, step, &effects);
        }
        rules.effects = effects;
    }

    /// Records a transaction that is not part of a schema's turn.
    pub(crate) fn record_turn(&self, kind: TurnKind, instance: SchemaId, checked: Moment) {
        if let Some(journal) = &self.journal {
            let mut turn = Turn::new(kind, instance);
            turn.checked = checked;
            journal.forward(&turn);
        }
    }

    fn apply(&self, rules: &mut RulesState, now: Nanos, effect: Effect) {
        match effect {
            Effect::Woken(id) => self
                .signals
                .post_within(&mut rules.notifications, id, Signal::Awake(now)),
            Effect::Slept { id, .. } => match &mut rules.shutdown_order {
                // Whoever looks at the end sees the last values.
                Some(order) => order.push(id),
                None => {
                    let ended = self.variables.close_exports(id);
                    rules.notifications.add_ended(ended);
                    self.signals
                        .post_within(&mut rules.notifications, id, Signal::Asleep);
                }
            },
            Effect::TakesOver { group, id } => {
                let level = self.group_subtree(&rules.hierarchy, group);
                let successors = subtree_with(&rules.hierarchy, id);
                let drivers = rules.commands.take_over(&level, &successors, now);
                self.signal_drivers(rules, &drivers);
            }
            Effect::Lapsed(id) => {
                let below = subtree_with(&rules.hierarchy, id);
                let could_act = |other| rules.hierarchy.could_act(other);
                let drivers = rules.commands.end_taken_over(id, &below, could_act, now);
                self.signal_drivers(rules, &drivers);
            }
            Effect::Refused(id) => {
                if let Some(description) = rules.refusal.take() {
                    let group = self.application.instances[id].group;
                    let refused = What::Refused {
                        schema: id,
                        description,
                        retry: group.map(|group| self.application.groups[group].retry_ns),
                    };
                    self.notify_observers(rules, &refused.at(now).into());
                }
            }
            Effect::Retries(_) => {}
            Effect::Granted(id) if rules.shutdown_order.is_none() => rules.commands.grant(id),
            Effect::Granted(_) => {}
            Effect::Withdrawn(id) => {
                self.variables.authority_end(id).record(now);
                rules.commands.withdraw(id);
            }
            Effect::Promoted(id) => self
                .signals
                .post_within(&mut rules.notifications, id, Signal::Promoted),
            Effect::Demoted(_) => {}
            Effect::Arbitrate { group, ticket, level } => {
                if let Some(father) = self.application.groups[group].father {
                    self.signals.post_within(
                        &mut rules.notifications,
                        father,
                        Signal::ArbitrationRequested { group, ticket, level },
                    );
                }
            }
            Effect::Brake { group } => {
                let level = self.group_subtree(&rules.hierarchy, group);
                let drivers = rules.commands.brake(&level, now);
                self.signal_drivers(rules, &drivers);
            }
            Effect::Hold { group, until } => {
                let level = self.group_subtree(&rules.hierarchy, group);
                let drivers = rules.commands.hold(&level, now, until);
                self.signal_drivers(rules, &drivers);
            }
            Effect::Changed { id, from, to } => {
                if let Some(is_awake) = &self.free[id] {
                    is_awake.store(to == State::Winner, Ordering::Release);
                }
                if tracing::level_filters::LevelFilter::current() >= tracing::Level::TRACE {
                    rules
                        .notifications
                        .messages
                        .push(Message::Changed { id, from, to });
                }
                self.notify_observers(
                    rules,
                    &Event::State(StateChange {
                        time: now,
                        schema: id,
                        from,
                        to,
                    }),
                );
            }
            Effect::Health { id, health } => {
                self.notify_observers(rules, &What::HealthChanged { schema: id, health }.at(now).into());
            }
            Effect::Decided(record) => {
                let more = rules.groups.record_decision(&record);
                self.notify_observers(rules, &Event::Decision(record));
                if let Some(more) = more {
                    self.note_chattering(rules);
                    self.notify_observers(rules, &more.into());
                }
            }
            Effect::TookOver {
                group,
                record,
                id,
                latency,
            } => self.report_takeover(rules, now, group, record, id, latency),
        }
    }

    fn note_chattering(&self, rules: &RulesState) {
        self.is_chattering
            .store(rules.groups.is_any_chattering(), Ordering::Relaxed);
    }

    /// Reports what waits for the next transaction, if anything does.
    pub(super) fn report_waiting(&self) {
        if !self.deferred_events.is_empty() || self.is_chattering.load(Ordering::Relaxed) {
            self.transact(|_| ());
        }
    }

    /// Signals drivers to carry out at once commands that cannot wait for their period.
    pub(super) fn signal_drivers(&self, rules: &mut RulesState, drivers: &[SchemaId]) {
        for driver in drivers {
            self.signals
                .post_within(&mut rules.notifications, *driver, Signal::Triggered);
        }
    }

    fn notify_transaction_observer(
        &self,
        rules: &mut RulesState,
        began: Nanos,
        step: TransactionInput,
        effects: &[Effect],
    ) {
        let RulesState {
            transaction_observer: observer,
            hierarchy,
            ..
        } = rules;
        if let Some(observer) = observer {
            observer.on_transaction(&ObservedTransaction {
                began,
                done: self.clock.now(),
                step,
                effects,
                hierarchy,
            });
        }
    }
}
