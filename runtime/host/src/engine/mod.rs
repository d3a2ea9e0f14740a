//! The parts of a running application that all executors share.
//!
//! [`Rules`] holds the hierarchy under one lock: every change of it is one transaction, whose effects are
//! carried out before the lock is released. So authority matches the rules at every instant (R1, R7),
//! whatever the threads do. The engine starts no thread and calls no plugin; it signals the executor through
//! [`Notifier`].

mod abandoned;
mod guard_wiring;
mod guards;
mod isolation;
mod operators;
mod outcome;
mod panels;
mod reload;
mod rules;
mod services;
mod snapshot;
mod wiring;

#[cfg(test)]
mod tests;

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use jde_abi::describe::Kind;
use jde_app::{Application, RoleId};
use jde_board::{Board, Watch};
use jde_core::{Hierarchy, Nanos, SchemaId, Table, Timer, Transaction};
use jde_isolation::Program;
use jde_isolation::authority::AuthorityTable;
use jde_isolation::process::ProcessTable;
use jde_records::event::{Observer, Outcome};
use jde_records::turn::{Moment, OnTurn, TurnKind};
use parking_lot::Mutex;

use crate::clock::Clock;
use crate::instance::Ports;
use crate::journal::Journal;
use crate::metrics::InstanceMetrics;
use crate::mock::ResolvedMock;
use crate::panels::Panels;
use crate::reload::BuildRegistry;
use crate::stalls::Stalls;
use crate::transaction_observer::TransactionObserver;
use crate::turn_order::staggers;
pub(crate) use operators::Actor;
use operators::Operators;
pub(crate) use outcome::RunOutcome;
pub(crate) use rules::{Notifier, Rules, Signal};
pub(crate) use services::FatherAction;
pub(crate) use wiring::Variables;

/// The shared part of a running application.
pub(crate) struct Engine {
    pub(crate) application: Arc<Application>,
    pub(crate) board: Arc<Board>,
    pub(crate) variables: Arc<Variables>,
    pub(crate) clock: Arc<Clock>,
    /// How much earlier than the last of the instances woken together each instance is due, ns.
    staggers: Table<SchemaId, Nanos>,
    pub(crate) metrics: Table<SchemaId, InstanceMetrics>,
    /// Whether each instance has requested a turn that has not begun.
    turn_requests: Table<SchemaId, AtomicBool>,
    pub(crate) panels: Arc<Panels>,
    pub(crate) builds: BuildRegistry,
    pub(crate) processes: ProcessTable,
    /// What the processes of schemas know of their authority, if there are any.
    pub(crate) authority: Option<Arc<AuthorityTable>>,
    /// The mocks that take the place of instances.
    pub(crate) mocks: BTreeMap<SchemaId, Arc<ResolvedMock>>,
    pub(crate) id: u64,
    /// Receives the turns, if they are recorded.
    pub(crate) journal: Option<Arc<Journal>>,
    /// While this is `Some`, requests of fathers are collected here. A replay carries them out at the time of
    /// the original requests.
    deferred_actions: Mutex<Option<Vec<FatherAction>>>,
    /// Pairs of father and role whose last wake or sleep was refused. Only the first of consecutive refusals
    /// is reported.
    refused_requests: Mutex<BTreeSet<(SchemaId, RoleId)>>,
    pub(crate) rules: Arc<Rules>,
    /// When the host did not run.
    pub(crate) stalls: Arc<Stalls>,
    pub(crate) outcome: RunOutcome,
    pub(crate) operators: Operators,
    /// The engine's own watches on variables, kept as long as the engine.
    watches: Mutex<Vec<Watch>>,
}

impl Engine {
    /// Wires an application: declares all variables and gives every instance its ports.
    pub(crate) fn new(
        application: Application,
        clock: Clock,
        observers: Vec<Box<dyn Observer>>,
        on_turn: Option<OnTurn>,
        transaction_observer: Option<Box<dyn TransactionObserver>>,
        program: Option<Program>,
        mocks: BTreeMap<SchemaId, Arc<ResolvedMock>>,
    ) -> Result<(Arc<Self>, Table<SchemaId, Ports>), String> {
        static NEXT: AtomicU64 = AtomicU64::new(1);
        let hierarchy = Hierarchy::new(application.spec()).map_err(|errors| {
            errors
                .iter()
                .map(ToString::to_string)
                .collect::<Vec<_>>()
                .join("; ")
        })?;
        let board = Arc::new(Board::new());
        let (variables, ports, mut commands) =
            wiring::wire(&application, &board).map_err(|error| error.to_string())?;
        let meters = application.instances.map_ids(|_| InstanceMetrics::default());
        for (meter, instance) in meters.iter().zip(&application.instances) {
            meter.period.store(instance.period_ns, Ordering::Relaxed);
        }
        let is_isolated = application
            .instances
            .iter()
            .any(|instance| instance.isolate.is_some());
        // Without the table, processes ask about every command.
        let authority = is_isolated
            .then(|| AuthorityTable::new(application.instances.len()))
            .and_then(Result::ok)
            .map(Arc::new);
        commands.show_authority(authority.clone());
        let application = Arc::new(application);
        let clock = Arc::new(clock);
        let journal = on_turn.map(|on_turn| Arc::new(Journal::new(on_turn)));
        let variables = Arc::new(variables);
        let stalls = Arc::new(Stalls::default());
        let rules = Arc::new(Rules::new(
            &application,
            (&clock, &stalls),
            journal.clone(),
            hierarchy,
            (&variables, commands),
            observers,
            transaction_observer,
        ));
        let operators = Operators::new(&application, &clock, &board, &variables, &rules, journal.clone());
        let staggers = staggers(&application.instances, &clock);
        let panels = Arc::new(Panels::new(application.instances.ids()));
        let builds = BuildRegistry::new(application.instances.ids());
        let processes = ProcessTable::new(application.instances.ids(), program);
        let engine = Arc::new(Self {
            application,
            board,
            variables,
            clock,
            staggers,
            turn_requests: meters.map_ids(|_| AtomicBool::new(false)),
            metrics: meters,
            panels,
            builds,
            processes,
            authority,
            mocks,
            id: NEXT.fetch_add(1, Ordering::Relaxed),
            deferred_actions: Mutex::default(),
            refused_requests: Mutex::default(),
            journal,
            rules,
            stalls,
            outcome: RunOutcome::default(),
            operators,
            watches: Mutex::default(),
        });
        Ok((engine, ports))
    }

    /// How much earlier than the last of the instances woken together this instance is due, ns.
    pub(crate) fn stagger(&self, instance: SchemaId) -> Nanos {
        self.staggers[instance]
    }

    /// Connects the executor, and lets publications signal its instances. Called once, before
    /// [`Rules::start`].
    pub(crate) fn attach(&self, notifier: &Arc<dyn Notifier>) {
        self.retain_watches(wiring::watch_triggers(self, notifier));
        self.rules.signals.attach(notifier);
    }

    /// Keeps watches for as long as the engine lives.
    pub(crate) fn retain_watches(&self, watches: impl IntoIterator<Item = Watch>) {
        let mut kept = self.watches.lock();
        kept.extend(watches);
    }

    /// Runs the rules' timers that are due.
    pub(crate) fn tick(&self) {
        let ((), moment) = self.rules.transact_recorded(|transaction| {
            self.excuse_unscheduled(transaction);
            transaction.tick();
        });
        self.rules.record_turn(TurnKind::Ticked, SchemaId(0), moment);
    }

    /// Excuses fathers that had no chance to arbitrate. A father is excused if its time is over, no other
    /// call of it runs, and it was not called to answer in the first half of its time. In that case its
    /// thread was notified and did not run, or no worker was free: the machine was late, not the father. It is excused
    /// as well if the host did not run meanwhile.
    fn excuse_unscheduled(&self, transaction: &mut Transaction) {
        let now = transaction.now();
        let over = transaction.timers().filter_map(|(due, timer)| match timer {
            Timer::Arbitration(group) if due <= now => Some((due, group)),
            _ => None,
        });
        for (due, group) in over.collect::<Vec<_>>() {
            let about = &self.application.groups[group];
            let latest = due.saturating_sub(about.budget_ns / 2);
            let asked = transaction.pending_arbitration(group);
            let stalled = self.stalls.within(due.saturating_sub(about.budget_ns), now) > 0;
            if about
                .father
                .is_some_and(|father| stalled || !self.metrics[father].is_busy_with(asked, latest))
            {
                transaction.excuse(group);
            }
        }
    }

    /// Reports that a call into the instance failed, and retracts the instance's exports. A driver that never
    /// completed an iteration ends the application, which cannot work without it.
    pub(crate) fn report_fault(&self, instance: SchemaId, reason: String) -> Moment {
        self.report_fault_with(instance, reason, || ())
    }

    /// The same, with something to do within its transaction, before a later one can wake the instance.
    pub(super) fn report_fault_with(
        &self,
        instance: SchemaId,
        reason: String,
        within: impl FnOnce(),
    ) -> Moment {
        let meter = &self.metrics[instance];
        // The event has the whole reason, such as a traceback.
        let summary = reason.lines().next().unwrap_or_default();
        tracing::error!(target: "jde::event", schema = self.name(instance), "faulted: {summary}");
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
        self.rules
            .transact_for(instance, |transaction| {
                // In the transaction, so that a snapshot shows the fault with its effect.
                meter.faults.fetch_add(1, Ordering::Relaxed);
                within();
                transaction.faulted(instance, reason);
            })
            .1
    }

    /// Ends the values of which the validity is over (R19). Returns the last instant at which no other can be.
    pub(crate) fn expire_values(&self, now: Nanos) -> Nanos {
        // A value that is published later expires later.
        let next = self.variables.expire(now).unwrap_or(Nanos::MAX);
        next.min(now.saturating_add(self.variables.shortest_validity()))
    }

    /// Ends the values of an instance that expire, because it sleeps (R19), unless the application ends.
    pub(crate) fn end_values(&self, instance: SchemaId) {
        if !self.rules.is_ending() {
            let ended = self.variables.close_exports(instance);
            ended.for_each(|variable| variable.report_end());
        }
    }

    /// Sets the period of an instance from its next iteration on.
    pub(crate) fn set_period(&self, instance: SchemaId, period: Nanos) {
        self.metrics[instance].period.store(period, Ordering::Relaxed);
        self.rules.set_period(instance, period);
    }

    /// Requests a turn of an instance in addition to the periodic ones, if it is awake (R12).
    /// Requests before that turn begins are one, so that a flood of them is no flood of signals.
    pub(crate) fn request_turn(&self, instance: SchemaId) {
        if !self.turn_requests[instance].swap(true, Ordering::AcqRel) {
            self.rules.signals.send(instance, Signal::TurnRequested);
        }
    }

    /// The turn that an instance requested begins, or it has none. What happened before a request is visible to it.
    pub(crate) fn end_turn_request(&self, instance: SchemaId) {
        self.turn_requests[instance].swap(false, Ordering::AcqRel);
    }

    /// The host itself panicked: brakes all actuators and ends the application.
    pub(crate) fn report_panic(&self) {
        self.rules.brake_all();
        self.outcome.conclude(Outcome::Broken(String::from(
            "the host itself panicked; this is a fault of jde, please report it",
        )));
    }

    pub(crate) fn name(&self, instance: SchemaId) -> &str {
        &self.application.instances[instance].name
    }
}
