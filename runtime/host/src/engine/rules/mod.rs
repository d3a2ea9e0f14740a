//! The rules under one lock: the only place that locks them.
//!
//! Every change of the hierarchy is one [`Rules::transact`], which carries out the effects of the change in
//! order before it releases the lock. Readers use [`Rules::read`]. Nothing under the lock logs, waits, or fails because
//! the machine has nothing left.

mod commands;
mod delays;
mod messages;
mod reports;
mod signals;
mod statistics;
mod transact;

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use jde_abi::describe::Kind;
use jde_app::{Application, InstanceConfig};
use jde_core::{Effect, GroupId, Hierarchy, Nanos, SchemaId, State, Table};
use jde_records::event::Observer;
use jde_records::turn::{Operation, TurnKind};
use parking_lot::{Mutex, MutexGuard};

use super::Variables;
use crate::clock::Clock;
use crate::journal::Journal;
use crate::stalls::Stalls;
use crate::transaction_observer::{TransactionInput, TransactionObserver};
pub(crate) use commands::{Command, Commands};
use delays::MachineDelays;
pub(crate) use signals::{Notifier, Signal};
use signals::{PendingNotifications, Signals};
use statistics::{DeferredEvents, GroupStatistics};
pub(crate) use transact::IterationPermission;

/// The hierarchy, and everything that its transactions need.
pub(crate) struct Rules {
    application: Arc<Application>,
    clock: Arc<Clock>,
    variables: Arc<Variables>,
    stalls: Arc<Stalls>,
    journal: Option<Arc<Journal>>,
    state: Mutex<RulesState>,
    pub(super) signals: Signals,
    deferred_events: DeferredEvents,
    /// Whether any group chatters.
    is_chattering: AtomicBool,
    /// Whether each schema is awake that needs nobody's permission to iterate; `None` for the others.
    free: Table<SchemaId, Option<AtomicBool>>,
    pub(crate) delays: MachineDelays,
}

/// The state that only transactions change.
pub(crate) struct RulesState {
    pub(crate) hierarchy: Hierarchy,
    effects: Vec<Effect>,
    /// The reason of the refusal that is being reported, until observers receive it.
    refusal: Option<String>,
    observers: Vec<Box<dyn Observer>>,
    transaction_observer: Option<Box<dyn TransactionObserver>>,
    commands: Commands,
    pub(crate) groups: GroupStatistics,
    /// The timer that was last set.
    alarm: Option<Nanos>,
    /// What to notify and to log once the lock is free.
    notifications: PendingNotifications,
    /// While this is `Some`, no schema gains authority, and schemas put to sleep are listed here instead of
    /// signalled.
    shutdown_order: Option<Vec<SchemaId>>,
}

impl Rules {
    pub(super) fn new(
        application: &Arc<Application>,
        (clock, stalls): (&Arc<Clock>, &Arc<Stalls>),
        journal: Option<Arc<Journal>>,
        hierarchy: Hierarchy,
        (variables, commands): (&Arc<Variables>, Commands),
        observers: Vec<Box<dyn Observer>>,
        transaction_observer: Option<Box<dyn TransactionObserver>>,
    ) -> Self {
        let groups = GroupStatistics::new(&hierarchy);
        let is_free = |instance: &InstanceConfig| match instance.schema.kind {
            Kind::Motor => false,
            Kind::Perceptive => transaction_observer.is_none() && journal.is_none(),
            Kind::Driver => transaction_observer.is_none(),
        };
        let free = application
            .instances
            .iter()
            .map(|instance| is_free(instance).then(AtomicBool::default));
        let free = free.collect();
        Self {
            application: Arc::clone(application),
            clock: Arc::clone(clock),
            variables: Arc::clone(variables),
            stalls: Arc::clone(stalls),
            journal,
            state: Mutex::new(RulesState {
                hierarchy,
                effects: Vec::new(),
                refusal: None,
                observers,
                transaction_observer,
                commands,
                groups,
                alarm: None,
                notifications: PendingNotifications::default(),
                shutdown_order: None,
            }),
            signals: Signals::default(),
            deferred_events: DeferredEvents::default(),
            is_chattering: AtomicBool::default(),
            free,
            delays: MachineDelays::default(),
        }
    }

    /// Reads the rules under their lock.
    pub(super) fn read<R>(&self, query: impl FnOnce(&RulesState) -> R) -> R {
        query(&self.state.lock())
    }

    /// Whether no thread holds the lock.
    #[cfg(test)]
    pub(super) fn is_unlocked(&self) -> bool {
        self.state.try_lock().is_some()
    }

    /// Sets the period of an instance, and renews the contracts that depend on it.
    pub(crate) fn set_period(&self, instance: SchemaId, period: Nanos) {
        self.transact(|transaction| transaction.set_period(instance, period));
        self.renew_contracts_of(instance);
    }

    /// Records whether an instance has a panel, and renews the contracts that depend on it.
    pub(crate) fn set_panel(&self, instance: SchemaId, has_panel: bool) {
        let changed = self.state.lock().hierarchy.set_panel(instance, has_panel);
        if changed {
            self.renew_contracts_of(instance);
        }
    }

    fn renew_contracts_of(&self, instance: SchemaId) {
        if let Some(group) = self.application.instances[instance].group {
            self.renew_contract(group);
        }
    }

    /// Recomputes the contracts of a group and of its father's group (R17), after the period of a member or a
    /// policy changed.
    pub(crate) fn renew_contract(&self, group: GroupId) {
        let father = self.application.groups[group].father;
        let above = father.and_then(|father| self.application.instances[father].group);
        let RulesState {
            hierarchy, groups, ..
        } = &mut *self.state.lock();
        groups.update_contract(hierarchy, group);
        if let Some(above) = above {
            groups.update_contract(hierarchy, above);
        }
    }

    /// Withdraws all authority and sends every actuator its neutral value. No schema gains authority
    /// afterwards. Returns the drivers that have commands to carry out.
    pub(crate) fn brake_all(&self) -> Vec<SchemaId> {
        let mut rules = self.state.lock();
        rules.shutdown_order.get_or_insert_default();
        let drivers = rules.commands.brake_all(self.clock.now());
        self.signal_drivers(&mut rules, &drivers);
        self.unlock(rules);
        drivers
    }

    /// Reports that a debugger holds a call of an instance, or lets it go on. While it is held, nothing below it has
    /// authority, and each command in force that it or a schema below it gave or took over is neutral.
    pub(crate) fn set_debugged(&self, instance: SchemaId, debugged: bool) {
        let mut rules = self.state.lock();
        let (subtree, moment) = self.transact_within(
            &mut rules,
            self.journal.as_deref(),
            |_| TransactionInput::Other,
            |transaction| {
                transaction.set_debugged(instance, debugged);
                subtree_with(transaction, instance)
            },
        );
        if debugged {
            let drivers = rules.commands.brake(&subtree, self.clock.now());
            self.signal_drivers(&mut rules, &drivers);
        }
        self.unlock(rules);
        let operation = if debugged {
            Operation::Debugged
        } else {
            Operation::WentOn
        };
        self.record_turn(TurnKind::Operated(operation), instance, moment);
    }

    /// Whether the application ends.
    pub(crate) fn is_ending(&self) -> bool {
        self.state.lock().shutdown_order.is_some()
    }

    /// Wakes another instance of a schema that the rules hold awake.
    pub(crate) fn awake_again(&self, instance: SchemaId) {
        let mut rules = self.state.lock();
        if rules.hierarchy.state(instance) != State::Slept {
            let awake = Signal::Awake(self.clock.now());
            self.signals
                .post_within(&mut rules.notifications, instance, awake);
        }
        self.unlock(rules);
    }

    /// Sends one instance to sleep, in the order that [`Self::put_to_sleep`] returned.
    pub(crate) fn send_to_sleep(&self, instance: SchemaId) {
        self.signals.send(instance, Signal::Asleep);
    }

    /// Puts everything to sleep. Returns the order in which it must happen, children before fathers.
    pub(crate) fn put_to_sleep(&self) -> Vec<SchemaId> {
        let moment = self.transact_shutdown();
        self.record_turn(TurnKind::Ended, SchemaId(0), moment);
        self.state
            .lock()
            .shutdown_order
            .replace(Vec::new())
            .unwrap_or_default()
    }

    /// The instances that act for a group: its members and all schemas below them.
    fn group_subtree(&self, hierarchy: &Hierarchy, group: GroupId) -> Vec<SchemaId> {
        let members = &self.application.groups[group].members;
        members
            .iter()
            .flat_map(|member| subtree_with(hierarchy, *member))
            .collect()
    }

    /// Ends a transaction: releases the lock, notifies the threads that its effects concern, and then logs.
    fn unlock(&self, mut rules: MutexGuard<'_, RulesState>) {
        if rules.notifications.is_empty() {
            return;
        }
        let pending = std::mem::take(&mut rules.notifications);
        drop(rules);
        self.signals.notify_all(&pending);
        self.log(pending.messages);
    }
}

/// A schema and all schemas below it.
fn subtree_with(hierarchy: &Hierarchy, id: SchemaId) -> Vec<SchemaId> {
    let below = hierarchy.subtree(id).into_iter();
    std::iter::once(id).chain(below).collect()
}
