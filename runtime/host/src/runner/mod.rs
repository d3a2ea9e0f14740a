//! Runs one instance, one turn at a time: the loop of the paper's figure 2, the same for every executor
//! (R16).
//!
//! A turn runs the work that is due, and returns the deadline of the next turn. It never waits; the executors
//! do.

mod arbitration;
mod call_handle;
mod cycle;
mod deadlines;
mod lifecycle;
mod panel;
mod phase;
mod replay;
mod swap;
mod trial;
mod turn_record;

use std::sync::Arc;
use std::sync::atomic::Ordering::Relaxed;
use std::time::Instant;

use jde_abi::describe::Kind;
use jde_core::{Nanos, SchemaId};
use jde_loader::build::Build;
use jde_records::turn::TurnKind;

use crate::engine::Engine;
use crate::inbox::Inbox;
use crate::instance::{PortAccess, Ports};
use crate::panels::DrawingPace;
use crate::running::StartError;
pub(crate) use call_handle::CallHandle;
use deadlines::Lateness;
use phase::Phase;
use turn_record::TurnRecord;

/// The least time from the end of a turn until one that an instance requests, or that rests after triggers, ns (R12).
const MIN_REST: Nanos = 200_000;

/// Takes one instance through the phases of its life.
pub(crate) struct Runner {
    engine: Arc<Engine>,
    number: SchemaId,
    kind: Kind,
    is_guard: bool,
    port_access: Arc<PortAccess>,
    phase: Phase,
    period: Nanos,
    lateness: Lateness,
    /// Its last iteration found an input without a value.
    lacks_value: bool,
    /// When it last iterated, plus one. In lockstep it iterates at most once an instant.
    last_iteration: Nanos,
    /// When its last turn with a check or an iteration ended.
    last_turn: Nanos,
    /// The time from the end of that turn until a requested one may begin: a flood of requests takes at most half of the
    /// time.
    rest: Nanos,
    /// When its last turn of any kind ended.
    idle_since: Nanos,
    /// Triggered turns that followed the one before without that rest.
    unrested: usize,
    /// A build took over in this turn; the result is reported at its end.
    takeover_pending: bool,
    /// The times of its drawings.
    pace: DrawingPace,
    record: TurnRecord,
}

impl Runner {
    pub(crate) fn new(engine: &Arc<Engine>, number: SchemaId, build: Build, ports: Ports) -> Self {
        engine.builds.set_initial(number, Arc::new(build));
        Self::with_ports(engine, number, ports)
    }

    /// A runner of the build that is in force for the instance.
    fn with_ports(engine: &Arc<Engine>, number: SchemaId, mut ports: Ports) -> Self {
        let config = &engine.application.instances[number];
        let kind = config.schema.kind;
        let panel = jde_loader::instance::panel_of(&engine.builds.current(number).table);
        engine.declare_panel(number, panel.map(|panel| panel.touch.is_some()));
        let journal = engine.journal.clone().filter(|_| kind != Kind::Driver);
        if let Some(journal) = &journal {
            ports.record_reads(journal);
        }
        Self {
            engine: Arc::clone(engine),
            number,
            kind,
            is_guard: config.schema.guard.is_some(),
            port_access: Arc::new(PortAccess::new(ports)),
            phase: Phase::Absent,
            period: config.period_ns,
            lateness: Lateness::default(),
            lacks_value: false,
            last_iteration: 0,
            last_turn: 0,
            rest: 0,
            idle_since: 0,
            unrested: 0,
            takeover_pending: false,
            pace: DrawingPace::default(),
            record: TurnRecord::new(number, journal, engine.clock.is_replayed()),
        }
    }

    /// Creates the instance before the application starts, so that a failure of the plugin is known at once.
    pub(crate) fn create_for_start(&mut self) -> Result<(), StartError> {
        let installed = self.create().map_err(|reason| {
            let application = &self.engine.application;
            let instance = &application.instances[self.number];
            let plugin = &application.plugins[instance.plugin].name;
            StartError::Create {
                schema: instance.name.clone(),
                type_name: format!("{plugin}/{}", instance.schema.name),
                reason,
            }
        })?;
        self.phase = Phase::Slept(installed);
        Ok(())
    }

    /// Takes a turn if it is due now, or if there are signals for it. Returns when the next turn is due; `None` if only
    /// a signal causes one.
    pub(crate) fn take_turn(&mut self, signals: Option<Inbox>) -> Option<Nanos> {
        self.record_delay(signals.as_ref().and_then(|inbox| inbox.since));
        let (triggered, promoted, touched) = signals.as_ref().map_or((false, false, false), |inbox| {
            (inbox.triggered, inbox.promoted, inbox.gesture_queued)
        });
        let is_resting = triggered && self.is_resting();
        if let Some(inbox) = signals {
            self.process_signals(inbox);
        }
        let mut has_run = false;
        let now = self.engine.clock.now();
        if let Some(awake) = self.phase.awake() {
            let deadlines = awake.deadlines;
            self.record.begin(TurnKind::Cycled(None));
            if is_resting {
                awake
                    .rested
                    .get_or_insert(self.last_turn.saturating_add(self.rest));
            }
            let is_triggered = match awake.rested {
                Some(begin) => begin <= now,
                None => triggered,
            };
            let is_due = now >= deadlines.due();
            let is_requested = awake.requested.is_some_and(|begin| begin <= now);
            if (is_due || is_requested) && awake.requested.take().is_some() {
                // What arrives from now on is of another turn.
                self.engine.end_turn_request(self.number);
            }
            if is_due {
                awake.is_due_at_once = false;
                self.run_cycle(now, deadlines);
                has_run = true;
            } else if is_requested {
                self.run_requested(now);
                has_run = true;
            } else if is_triggered || promoted && self.engine.rules.is_taking(self.number) {
                // The values behind the choice may be a period old, so it checks again before it acts (R8).
                self.react(now);
                has_run = true;
            }
            if has_run && let Some(awake) = self.phase.awake() {
                // Whatever the turn was, it saw what triggered it.
                awake.rested = None;
            }
            if has_run && !is_due {
                let took = self.engine.clock.now().saturating_sub(now);
                self.engine.metrics[self.number].record_between(took);
            }
            self.record.finish();
            if has_run {
                self.draw();
            }
            self.release_values();
        }
        if touched {
            self.take_gesture();
        }
        self.end_turn(has_run, now);
        match &self.phase {
            Phase::Awake(_, awake) => {
                let due = awake.deadlines.due();
                let added = awake.requested.into_iter().chain(awake.rested);
                Some(added.fold(due, Nanos::min))
            }
            Phase::Slept(_) if self.engine.clock.is_real() => self.draw_asleep(),
            Phase::Absent | Phase::Slept(_) => None,
        }
    }

    /// Records how late a turn begins after the instance was due or signalled, and its last turn had ended.
    fn record_delay(&mut self, signalled: Option<Instant>) {
        let clock = &self.engine.clock;
        if !clock.is_real() {
            return;
        }
        let now = clock.now();
        let signalled = signalled.map(|at| now.saturating_sub(clock.since(at)));
        let due = self.phase.awake().map(|awake| awake.deadlines.due());
        let ready = due.into_iter().chain(signalled).min().unwrap_or(now);
        let late = now.saturating_sub(ready.max(self.idle_since));
        self.engine.rules.delays.record(Some(self.number), now, late);
    }

    /// Whether a triggered turn must rest (R12): it would follow the one before without a rest, as more than the longest
    /// chain of schemas have. In lockstep, where turns take no time, the executor ends such a loop.
    fn is_resting(&mut self) -> bool {
        let has_rested = self.engine.clock.now() >= self.last_turn.saturating_add(self.rest);
        if has_rested || !self.engine.clock.is_real() {
            self.unrested = 0;
            return false;
        }
        self.unrested = self.unrested.saturating_add(1);
        let rests = self.unrested > self.engine.metrics.len();
        if rests {
            self.engine.metrics[self.number]
                .triggers_dropped
                .fetch_add(1, Relaxed);
        }
        rests
    }

    /// Processes the signals, before anything is checked.
    fn process_signals(&mut self, inbox: Inbox) {
        for (group, ticket, level) in inbox.arbitration_requests {
            self.arbitrate(group, ticket, &level);
        }
        if inbox.replaced {
            if self.phase.trial().is_some() {
                self.engine
                    .roll_back_build(self.number, "a call of it did not return in time");
            }
            self.give_up();
        }
        if inbox.unloaded {
            self.unload();
        }
        // Before it awakes: its first turn occurs at once, whatever its period.
        if inbox.period_changed {
            self.retime();
        }
        for awake in inbox.transitions {
            match awake {
                Some(time) => self.wake_up(time),
                None => self.fall_asleep(),
            }
        }
        if inbox.turn_requested {
            self.add_turn();
        }
        if inbox.build_pending
            && let Some(swap) = self.engine.builds.start_swap(self.number)
        {
            self.swap(&swap);
        }
    }

    /// Returns its period, ns.
    pub(crate) fn period(&self) -> Nanos {
        self.period
    }

    /// Returns a handle that gives up a call of it from another thread.
    pub(crate) fn call_handle(&self) -> CallHandle {
        CallHandle::new(&self.engine, self.number, &self.port_access)
    }

    /// Ends the instance for good.
    pub(crate) fn destroy(&mut self) {
        self.fall_asleep();
        self.end_instance();
    }

    /// Ends a turn: a takeover in it has succeeded so far, and a trial may be over.
    fn end_turn(&mut self, has_run: bool, begun: Nanos) {
        let now = self.engine.clock.now();
        self.idle_since = now;
        if has_run {
            self.last_turn = now;
            self.rest = MIN_REST.max(now.saturating_sub(begun));
        }
        if std::mem::take(&mut self.takeover_pending) {
            self.engine.builds.finish_swap(self.number, Ok(()));
        }
        if let Some(awake) = self.phase.awake()
            && std::mem::take(&mut awake.is_due_at_once)
        {
            awake.deadlines.add(now);
        }
        if let Some(trial) = self.phase.trial()
            && trial.survive(has_run, now)
        {
            self.end_trial();
        }
    }

    /// Applies a new period: the next iteration is due one new period after the last.
    pub(crate) fn retime(&mut self) {
        let new = self.engine.variables.newest_period(self.number);
        let Some(period) = new.filter(|period| *period != self.period) else {
            return;
        };
        if let Some(awake) = self.phase.awake() {
            let now = self.engine.clock.now();
            awake.deadlines.retime(self.period, period, now);
        }
        self.period = period;
        self.engine.set_period(self.number, period);
    }

    /// Adds a turn, which begins now unless the one before has only just ended (R12). Its deadlines stay.
    fn add_turn(&mut self) {
        let now = self.engine.clock.now();
        let begin = self.last_turn.saturating_add(self.rest).max(now);
        match self.phase.awake() {
            Some(awake) => _ = awake.requested.get_or_insert(begin),
            None => self.engine.end_turn_request(self.number),
        }
    }

    /// Adds the last call of the instance to the record of the turn.
    fn record_look(&mut self) {
        if let Some(instance) = self.phase.instance() {
            self.record.add_look(instance);
        }
    }

    /// Releases the values read, so that the next turn sees the newest.
    fn release_values(&mut self) {
        if let Phase::Awake(installed, _) = &mut self.phase {
            installed.instance.release_values();
        }
    }
}
