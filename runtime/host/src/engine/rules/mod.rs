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

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use jde_app::Application;
use jde_core::{Effect, GroupId, Hierarchy, Nanos, SchemaId, State};
use jde_records::event::Observer;
use jde_records::turn::{Operation, TurnKind};

use super::{Variables, schema};
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
    shutdown_order: Option<Vec<usize>>,
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
        let groups = GroupStatistics::new(application.groups.len(), &hierarchy);
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
            delays: MachineDelays::default(),
        }
    }

    /// Reads the rules under their lock.
    pub(super) fn read<R>(&self, query: impl FnOnce(&RulesState) -> R) -> R {
        query(&self.lock())
    }

    /// Whether no thread holds the lock.
    #[cfg(test)]
    pub(super) fn is_unlocked(&self) -> bool {
        self.state.try_lock().is_ok()
    }

    /// Sets the period of an instance, and renews the contracts that depend on it.
    pub(crate) fn set_period(&self, instance: usize, period: Nanos) {
        self.transact(|hierarchy, _, _| hierarchy.set_period(schema(instance), period));
        self.renew_contracts_of(instance);
    }

    /// Records whether an instance has a panel, and renews the contracts that depend on it.
    pub(crate) fn set_panel(&self, instance: usize, has_panel: bool) {
        let changed = self.lock().hierarchy.set_panel(schema(instance), has_panel);
        if changed {
            self.renew_contracts_of(instance);
        }
    }

    fn renew_contracts_of(&self, instance: usize) {
        if let Some(group) = self.application.instances[instance].group {
            self.renew_contract(GroupId(group as u32));
        }
    }

    /// Recomputes the contracts of a group and of its father's group (R17), after the period of a member or a
    /// policy changed.
    pub(crate) fn renew_contract(&self, group: GroupId) {
        let father = self.application.groups[group.index()].father;
        let above = father.and_then(|father| self.application.instances[father].group);
        let RulesState {
            hierarchy, groups, ..
        } = &mut *self.lock();
        groups.update_contract(hierarchy, group);
        if let Some(above) = above {
            groups.update_contract(hierarchy, GroupId(above as u32));
        }
    }

    /// Withdraws all authority and sends every actuator its neutral value. No schema gains authority
    /// afterwards. Returns the drivers that have commands to carry out.
    pub(crate) fn brake_all(&self) -> Vec<usize> {
        let mut rules = self.lock();
        rules.shutdown_order.get_or_insert_default();
        let drivers = rules.commands.brake_all(self.clock.now());
        self.signal_drivers(&mut rules, &drivers);
        self.unlock(rules);
        drivers
    }

    /// Reports that a debugger holds a call of an instance, or lets it go on. While it is held, nothing below it has
    /// authority, and each command in force that it or a schema below it gave or took over is neutral.
    pub(crate) fn set_debugged(&self, instance: usize, debugged: bool) {
        let id = schema(instance);
        let mut rules = self.lock();
        let (subtree, moment) = self.transact_within(
            &mut rules,
            self.journal.as_deref(),
            |_| TransactionInput::Other,
            |hierarchy, _, out| {
                hierarchy.set_debugged(id, debugged, out);
                subtree_with(hierarchy, id)
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
        self.lock().shutdown_order.is_some()
    }

    /// Wakes another instance of a schema that the rules hold awake.
    pub(crate) fn awake_again(&self, instance: usize) {
        let mut rules = self.lock();
        if rules.hierarchy.state(schema(instance)) != State::Slept {
            let awake = Signal::Awake(self.clock.now());
            self.signals
                .post_within(&mut rules.notifications, instance, awake);
        }
        self.unlock(rules);
    }

    /// Sends one instance to sleep, in the order that [`Self::put_to_sleep`] returned.
    pub(crate) fn send_to_sleep(&self, instance: usize) {
        self.signals.send(instance, Signal::Asleep);
    }

    /// Puts everything to sleep. Returns the order in which it must happen, children before fathers.
    pub(crate) fn put_to_sleep(&self) -> Vec<usize> {
        let moment = self.transact_shutdown();
        self.record_turn(TurnKind::Ended, 0, moment);
        self.lock().shutdown_order.replace(Vec::new()).unwrap_or_default()
    }

    /// The instances that act for a group: its members and all schemas below them.
    fn group_subtree(&self, hierarchy: &Hierarchy, group: GroupId) -> Vec<usize> {
        let members = &self.application.groups[group.index()].members;
        members
            .iter()
            .flat_map(|member| subtree_with(hierarchy, schema(*member)))
            .collect()
    }

    /// Ends a transaction: releases the lock, notifies the threads that its effects concern, and then logs.
    fn unlock(&self, mut rules: MutexGuard<'_, RulesState>) {
        let pending = rules.notifications.take();
        drop(rules);
        if let Some(pending) = pending {
            self.signals.notify_all(&pending);
            self.log(pending.messages);
        }
    }

    /// Locks the rules. A panic inside a transaction is a fault of the host and ends the application, so a
    /// poisoned lock only serves the shutdown.
    fn lock(&self) -> MutexGuard<'_, RulesState> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// A schema and all schemas below it.
fn subtree_with(hierarchy: &Hierarchy, id: SchemaId) -> Vec<usize> {
    let below = hierarchy.subtree(id).into_iter();
    std::iter::once(id).chain(below).map(SchemaId::index).collect()
}
