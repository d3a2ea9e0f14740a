//! The state that all executors share: the rules under one lock, the board, the clock, and the effects of
//! every transaction.
//!
//! Every change of the hierarchy is one [`Engine::transact`]: it applies the change to the rules and carries
//! out their effects in order before it releases the lock. So authority matches the rules at every instant
//! (R1, R7), whatever the threads do. The engine starts no thread and calls no plugin; it signals the
//! executor through [`Notifier`].

mod abandoned;
mod authority;
mod halt;
mod isolation;
mod observe;
mod operate;
mod outcome;
mod panels;
mod reload;
mod services;
mod signals;
mod transact;
mod unload;
mod wiring;

#[cfg(test)]
mod tests;

use std::collections::BTreeSet;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use jde_abi::describe::Kind;
use jde_app::Application;
use jde_board::{Board, Watch};
use jde_core::{ArbitrationReply, Check, Effect, GroupId, Hierarchy, Nanos, SchemaId, Timer};
use jde_isolation::Program;
use jde_isolation::process::ProcessTable;
use jde_records::event::{Event, Observer, Outcome};
use jde_records::turn::{Moment, OnTurn, Turn};

use crate::clock::Clock;
use crate::instance::Ports;
use crate::journal::Journal;
use crate::metrics::InstanceMetrics;
use crate::panels::Panels;
use crate::reload::BuildRegistry;
use crate::transaction_observer::TransactionObserver;
use crate::turn_order::staggers;
use authority::Commands;
use observe::{DeferredEvents, GroupStatistics};
use operate::OperatorHolds;
pub(crate) use outcome::RunOutcome;
pub(crate) use services::FatherAction;
pub(crate) use signals::{Notifier, Signal};
use signals::{PendingNotifications, Signals};
pub(crate) use transact::IterationPermission;
pub(crate) use wiring::Variables;

/// The shared part of a running application.
pub(crate) struct Engine {
    pub(crate) application: Application,
    pub(crate) board: Board,
    pub(crate) variables: Variables,
    pub(crate) clock: Clock,
    /// How much earlier than the last of the instances woken together each instance is due, ns.
    staggers: Vec<Nanos>,
    pub(crate) metrics: Vec<InstanceMetrics>,
    pub(crate) panels: Arc<Panels>,
    pub(crate) builds: BuildRegistry,
    pub(crate) processes: ProcessTable,
    pub(crate) id: u64,
    /// Receives the turns, if they are recorded.
    pub(crate) journal: Option<Arc<Journal>>,
    /// While this is `Some`, requests of fathers are collected here. A replay carries them out at the time of
    /// the original requests.
    deferred_actions: Mutex<Option<Vec<FatherAction>>>,
    rules: Mutex<RulesState>,
    signals: Signals,
    pub(crate) outcome: RunOutcome,
    /// What operators have changed and not released. This lock is taken after the rules' lock, or alone.
    holds: Mutex<OperatorHolds>,
    deferred_events: DeferredEvents,
    /// The engine's own watches on variables, kept as long as the engine.
    watches: Mutex<Vec<Watch>>,
}

/// The state that only transactions change.
pub(crate) struct RulesState {
    hierarchy: Hierarchy,
    effects: Vec<Effect>,
    observers: Vec<Box<dyn Observer>>,
    transaction_observer: Option<Box<dyn TransactionObserver>>,
    commands: Commands,
    groups: GroupStatistics,
    /// Pairs of father and role whose last wake or sleep was refused. Only the first of consecutive refusals
    /// is reported.
    refused_requests: BTreeSet<(usize, usize)>,
    /// The timer that was last set.
    alarm: Option<Nanos>,
    /// What to notify once the lock is free.
    notifications: PendingNotifications,
    /// While this is `Some`, no schema gains authority, and schemas put to sleep are listed here instead of
    /// signalled.
    shutdown_order: Option<Vec<usize>>,
}

impl Engine {
    /// Wires an application: declares all variables and gives every instance its ports.
    pub(crate) fn new(
        application: Application,
        clock: Clock,
        observers: Vec<Box<dyn Observer>>,
        on_turn: Option<OnTurn>,
        witness: Option<Box<dyn TransactionObserver>>,
        apart: Option<Program>,
    ) -> Result<(Arc<Self>, Vec<Ports>), String> {
        static NEXT: AtomicU64 = AtomicU64::new(1);
        let hierarchy = Hierarchy::new(application.spec()).map_err(|errors| {
            errors
                .iter()
                .map(ToString::to_string)
                .collect::<Vec<_>>()
                .join("; ")
        })?;
        let board = Board::new();
        let (variables, ports, commands) =
            wiring::wire(&application, &board).map_err(|error| error.to_string())?;
        let meters: Vec<InstanceMetrics> = application
            .instances
            .iter()
            .map(|_| InstanceMetrics::default())
            .collect();
        for (meter, instance) in meters.iter().zip(&application.instances) {
            meter.period.store(instance.period_ns, Ordering::Relaxed);
        }
        let groups = GroupStatistics::new(application.groups.len(), &hierarchy);
        let rules = RulesState {
            hierarchy,
            effects: Vec::new(),
            observers,
            transaction_observer: witness,
            commands,
            groups,
            refused_requests: BTreeSet::new(),
            alarm: None,
            notifications: PendingNotifications::default(),
            shutdown_order: None,
        };
        let early = staggers(&application.instances, &clock);
        let panels = Arc::new(Panels::new(application.instances.len()));
        let builds = BuildRegistry::new(application.instances.len());
        let processes = ProcessTable::new(application.instances.len(), apart);
        let engine = Arc::new(Self {
            application,
            board,
            variables,
            clock,
            staggers: early,
            metrics: meters,
            panels,
            builds,
            processes,
            id: NEXT.fetch_add(1, Ordering::Relaxed),
            deferred_actions: Mutex::default(),
            journal: on_turn.map(|tell| Arc::new(Journal::new(tell))),
            rules: Mutex::new(rules),
            signals: Signals::default(),
            outcome: RunOutcome::default(),
            holds: Mutex::default(),
            deferred_events: DeferredEvents::default(),
            watches: Mutex::default(),
        });
        Ok((engine, ports))
    }

    /// How much earlier than the last of the instances woken together this instance is due, ns.
    pub(crate) fn stagger(&self, instance: usize) -> Nanos {
        self.staggers[instance]
    }

    /// Connects the executor, and lets publications signal its instances. Called once, before
    /// [`Self::start`].
    pub(crate) fn attach(&self, notifier: &Arc<dyn Notifier>) {
        self.retain_watches(wiring::watch_triggers(self, notifier));
        self.signals.attach(notifier);
    }

    /// Keeps watches for as long as the engine lives.
    pub(crate) fn retain_watches(&self, watches: impl IntoIterator<Item = Watch>) {
        let mut kept = self.watches.lock().unwrap_or_else(PoisonError::into_inner);
        kept.extend(watches);
    }

    pub(crate) fn start(&self) {
        let ((), moment) = self.transact_recorded(|hierarchy, now, out| hierarchy.start(now, out));
        self.record_turn(Turn::STARTED, 0, 0, moment);
    }

    /// Runs the rules' timers that are due.
    pub(crate) fn tick(&self) {
        let ((), moment) = self.transact_recorded(|hierarchy, now, out| {
            self.excuse_unscheduled(hierarchy, now);
            hierarchy.tick(now, out);
        });
        self.record_turn(Turn::TICKED, 0, 0, moment);
    }

    /// Excuses fathers that had no chance to arbitrate. A father is excused if its time is over, no other
    /// call of it runs, and it was not called to answer in the first half of its time. In that case its
    /// thread was notified and did not run, or no worker was free: the machine was late, not the father.
    fn excuse_unscheduled(&self, hierarchy: &mut Hierarchy, now: Nanos) {
        let over = hierarchy.timers().filter_map(|(due, timer)| match timer {
            Timer::Arbitration(group) if due <= now => Some((due, group)),
            _ => None,
        });
        for (due, group) in over.collect::<Vec<_>>() {
            let about = &self.application.groups[group.index()];
            let latest = due.saturating_sub(about.budget_ns / 2);
            let asked = hierarchy.pending_arbitration(group);
            if about
                .father
                .is_some_and(|father| !self.metrics[father].is_busy_with(asked, latest))
            {
                hierarchy.excuse(group);
            }
        }
    }

    pub(crate) fn next_timer(&self) -> Option<Nanos> {
        self.lock().hierarchy.next_timer()
    }

    /// Reports the result of a precondition.
    pub(crate) fn report_check(&self, instance: usize, check: Check) -> Moment {
        let told = |hierarchy: &mut Hierarchy, now, out: &mut Vec<Effect>| {
            hierarchy.checked(now, schema(instance), check, out);
        };
        self.transact_for(instance, told).1
    }

    /// Asks the rules for permission to iterate.
    pub(crate) fn request_iteration(&self, instance: usize) -> IterationPermission {
        self.transact_begin(instance, None, false).1
    }

    /// Asks for permission for the first iteration since the instance became WINNER. Refused if that
    /// iteration has begun already.
    pub(crate) fn request_first_iteration(&self, instance: usize) -> IterationPermission {
        self.transact_begin(instance, None, true).1
    }

    /// [`Self::checked`] and then at once [`Self::begin`] or [`Self::request_first_iteration`].
    pub(crate) fn report_check_and_request(
        &self,
        instance: usize,
        check: Check,
        first: bool,
    ) -> (Moment, IterationPermission) {
        self.transact_begin(instance, Some(check), first)
    }

    /// Whether the instance became WINNER and has not begun to iterate since.
    pub(crate) fn is_taking(&self, instance: usize) -> bool {
        self.lock().hierarchy.is_taking(schema(instance))
    }

    /// Reports the end of an iteration.
    pub(crate) fn report_iteration_end(&self, instance: usize) -> Moment {
        self.transact_end(self.journal_of(instance), instance)
    }

    /// Reports that a call into the instance failed, and retracts the instance's exports. A driver that never
    /// completed an iteration ends the application, which cannot work without it.
    pub(crate) fn report_fault(&self, instance: usize, reason: String) -> Moment {
        let meter = &self.metrics[instance];
        tracing::error!(schema = self.name(instance), "faulted: {reason}");
        let kind = self.application.instances[instance].schema.kind;
        if kind == Kind::Driver && !meter.started.load(Ordering::Relaxed) {
            let name = self.name(instance);
            self.outcome.conclude(Outcome::Broken(format!(
                "driver `{name}` could not start: {reason}"
            )));
        }
        // Retracting calls watchers, so no lock may be held. It precedes the restart, so that it retracts no
        // newer value.
        self.variables.retract_exports(instance);
        self.transact_for(instance, |hierarchy, now, out| {
            // In the transaction, so that a snapshot shows the fault with its effect.
            meter.faults.fetch_add(1, Ordering::Relaxed);
            hierarchy.faulted(now, schema(instance), reason, out);
        })
        .1
    }

    /// The host itself panicked: brakes all actuators and ends the application.
    pub(crate) fn report_panic(&self) {
        self.brake_all();
        self.outcome.conclude(Outcome::Broken(String::from(
            "the host itself panicked; this is a fault of jde, please report it",
        )));
    }

    /// Reports the answer of a father.
    pub(crate) fn report_arbitration(&self, group: GroupId, ticket: u64, answer: ArbitrationReply) -> Moment {
        let told = |hierarchy: &mut Hierarchy, now, out: &mut Vec<Effect>| {
            hierarchy.arbitrated(now, group, ticket, answer, out);
        };
        self.transact_recorded(told).1
    }

    /// Reports that a deadline was missed or met.
    pub(crate) fn report_deadline(&self, instance: usize, met: bool) {
        self.transact(|hierarchy, _, out| {
            if met {
                hierarchy.on_time(schema(instance), out);
            } else {
                hierarchy.overrun(schema(instance), out);
            }
        });
    }

    pub(crate) fn name(&self, instance: usize) -> &str {
        &self.application.instances[instance].name
    }

    /// The instances that act for a group: its members and all schemas below them.
    fn group_subtree(&self, hierarchy: &Hierarchy, group: GroupId) -> Vec<usize> {
        let members = &self.application.groups[group.index()].members;
        members
            .iter()
            .flat_map(|member| subtree_with(hierarchy, schema(*member)))
            .collect()
    }

    /// Ends a transaction: releases the lock, then notifies the threads that its effects concern.
    fn unlock(&self, mut rules: MutexGuard<'_, RulesState>) {
        let pending = rules.notifications.take();
        drop(rules);
        if let Some(pending) = pending {
            self.signals.notify_all(&pending);
        }
    }

    fn notify_observers(&self, rules: &mut RulesState, event: &Event) {
        for observer in &mut rules.observers {
            observer.on_event(event);
        }
    }

    /// Locks the rules. A panic inside a transaction is a fault of the host and ends the application, so a
    /// poisoned lock only serves the shutdown.
    fn lock(&self) -> MutexGuard<'_, RulesState> {
        self.rules.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// A schema and all schemas below it.
fn subtree_with(hierarchy: &Hierarchy, id: SchemaId) -> Vec<usize> {
    let below = hierarchy.subtree(id).into_iter();
    std::iter::once(id).chain(below).map(SchemaId::index).collect()
}

fn schema(instance: usize) -> SchemaId {
    SchemaId(instance as u32)
}
