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
mod panels;
mod reload;
mod services;
mod transact;
mod unload;
mod wiring;

#[cfg(test)]
mod tests;

use std::collections::BTreeSet;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, OnceLock, PoisonError, Weak};

use jde_abi::describe::Kind;
use jde_app::Application;
use jde_board::{Board, Watch};
use jde_core::{ArbitrationReply, Check, Effect, GroupId, Hierarchy, Level, Nanos, SchemaId, Timer};
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
pub(crate) use services::FatherAction;
pub(crate) use transact::IterationPermission;
pub(crate) use wiring::Variables;

/// Delivers signals to the runners of instances and sets the rules' timer.
///
/// [`Notifier::leave`] and [`Notifier::set_timer`] take effect at once, in the order of the transactions that cause
/// them. They also run under the engine's lock, so they must not call the engine. The threads that wait are
/// notified once the lock is free: a notified thread may run before the notifier continues, and would
/// otherwise block on the rules' lock.
pub(crate) trait Notifier: Send + Sync {
    /// Leaves a signal for an instance. Returns whether a thread must be notified.
    fn post(&self, instance: usize, signal: Signal) -> bool;
    /// Notifies the thread that takes the instance's turns.
    fn notify(&self, instance: usize);
    /// Sets the next time at which the rules need [`Engine::tick`]. Returns whether a thread must be
    /// notified.
    fn set_timer(&self, next: Option<Nanos>) -> bool;
    /// Notifies the thread that waits for that time.
    fn notify_timer(&self);
}

/// A signal to an instance.
#[derive(Debug)]
pub(crate) enum Signal {
    /// The instance is awake since that time.
    Awake(Nanos),
    /// The instance is asleep.
    Asleep,
    /// A call of the instance hung, or its process died. The instance ends once no call of it runs; the next
    /// awakening creates a new one.
    Replaced,
    /// The instance was unloaded: it ends as soon as it sleeps.
    Unloaded,
    /// The instance became WINNER: iterate at once.
    Promoted,
    /// A value that triggers the instance was published (R12), or a driver received a command that cannot
    /// wait.
    Triggered,
    /// The instance must arbitrate (R4).
    ArbitrationRequested {
        group: GroupId,
        ticket: u64,
        level: Level,
    },
    /// The period was written.
    PeriodChanged,
    /// A viewer opened the instance's panel.
    PanelOpened,
    /// A gesture on the panel is waiting.
    GestureQueued,
    /// Another build is waiting to take over at the instance's next turn.
    BuildPending,
}

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
    notifier: OnceLock<Weak<dyn Notifier>>,
    outcome: Mutex<Option<Outcome>>,
    /// Whether there is an outcome. Checked far more often than it changes.
    concluded: AtomicBool,
    ended: Condvar,
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
    /// The timer that was last set through the bells.
    alarm: Option<Nanos>,
    /// What to notify once the lock is free.
    notifications: PendingNotifications,
    /// While this is `Some`, no schema gains authority, and schemas put to sleep are listed here instead of
    /// signalled.
    shutdown_order: Option<Vec<usize>>,
}

/// What to notify.
#[derive(Default)]
struct PendingNotifications {
    instances: Vec<usize>,
    alarm: bool,
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
            notifier: OnceLock::new(),
            outcome: Mutex::new(None),
            concluded: AtomicBool::new(false),
            ended: Condvar::new(),
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
    pub(crate) fn attach(&self, bells: &Arc<dyn Notifier>) {
        self.retain_watches(wiring::watch_triggers(self, bells));
        assert!(
            self.notifier.set(Arc::downgrade(bells)).is_ok(),
            "an engine has one executor"
        );
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
            self.conclude(Outcome::Broken(format!(
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
        self.conclude(Outcome::Broken(String::from(
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

    /// Ends the application. Only the first outcome counts.
    pub(crate) fn conclude(&self, outcome: Outcome) {
        let mut slot = self.outcome.lock().unwrap_or_else(PoisonError::into_inner);
        slot.get_or_insert(outcome);
        self.concluded.store(true, Ordering::Release);
        drop(slot);
        self.ended.notify_all();
    }

    pub(crate) fn outcome(&self) -> Option<Outcome> {
        if !self.concluded.load(Ordering::Acquire) {
            return None;
        }
        self.outcome
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
            .clone()
    }

    /// Blocks until the application concludes.
    pub(crate) fn wait_for_outcome(&self) -> Outcome {
        let slot = self.outcome.lock().unwrap_or_else(PoisonError::into_inner);
        let slot = self
            .ended
            .wait_while(slot, |slot| slot.is_none())
            .unwrap_or_else(PoisonError::into_inner);
        slot.clone().expect("waited for it")
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

    /// Signals an instance outside of the lock.
    fn send_signal(&self, instance: usize, signal: Signal) {
        if self.post_signal(instance, signal) {
            self.notify_instance(instance);
        }
    }

    /// Leaves a signal for an instance. Returns whether to notify its thread, outside of the lock.
    fn post_signal(&self, instance: usize, signal: Signal) -> bool {
        self.notifier().is_some_and(|bells| bells.post(instance, signal))
    }

    fn notify_instance(&self, instance: usize) {
        if let Some(bells) = self.notifier() {
            bells.notify(instance);
        }
    }

    /// Signals an instance within a transaction; [`Self::unlock`] notifies its thread.
    fn post_within(&self, rules: &mut RulesState, instance: usize, signal: Signal) {
        if self.post_signal(instance, signal) {
            rules.notifications.instances.push(instance);
        }
    }

    /// Ends a transaction: releases the lock, then notifies the threads that its effects concern.
    fn unlock(&self, mut rules: MutexGuard<'_, RulesState>) {
        let none = rules.notifications.instances.is_empty() && !rules.notifications.alarm;
        let calls = (!none).then(|| std::mem::take(&mut rules.notifications));
        drop(rules);
        if let Some(calls) = calls
            && let Some(bells) = self.notifier()
        {
            calls
                .instances
                .iter()
                .for_each(|instance| bells.notify(*instance));
            if calls.alarm {
                bells.notify_timer();
            }
        }
    }

    fn notifier(&self) -> Option<Arc<dyn Notifier>> {
        self.notifier.get().and_then(Weak::upgrade)
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
