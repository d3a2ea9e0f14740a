//! Runs one instance, one turn at a time: the loop of the paper's figure 2, the same for every executor
//! (R16).
//!
//! A turn runs the work that is due, and returns the deadline of the next turn. It never waits; the executors
//! do.

mod call_handle;
mod deadlines;
mod lifecycle;
mod panel;
mod process_death;
mod replay;
mod swap;

use std::sync::Arc;
use std::sync::atomic::Ordering::Relaxed;

use jde_abi::describe::Kind;
use jde_core::{ArbitrationReply, Check, GroupId, Level, Nanos};
use jde_loader::build::{self, Build};
use jde_records::turn::Turn;

use crate::engine::Engine;
use crate::inbox::Inbox;
use crate::instance::{self, Instance, PortAccess, Ports, TurnOverflow};
use crate::journal::Journal;
use crate::panels::DrawingPace;
use crate::running::StartError;
pub(crate) use call_handle::CallHandle;
use swap::Trial;

/// An instance and its state between turns.
pub(crate) struct Runner {
    engine: Arc<Engine>,
    number: usize,
    kind: Kind,
    port_access: Arc<PortAccess>,
    state: InstanceState,
    period: Nanos,
    /// One instant of the grid of its deadlines.
    anchor: Nanos,
    /// When its last check was. A change of readiness occurred after that.
    last_check: Nanos,
    /// When it last iterated, plus one. In lockstep it iterates at most once an instant.
    last_iteration: Nanos,
    /// Whether the last cycle and the last drawing were late.
    late: [bool; 2],
    /// The instance ends as soon as it sleeps.
    unloading: bool,
    /// Set while the current build is on trial.
    trial: Option<Trial>,
    /// A build took over in this turn; the result is reported at its end.
    takeover_pending: bool,
    /// A build took over in this turn; its next turn follows at once.
    is_due_at_once: bool,
    /// When its last turn with a check or an iteration ended.
    last_turn: Nanos,
    /// The times of its drawings.
    pace: DrawingPace,
    /// Receives the turns, if they are recorded.
    journal: Option<Arc<Journal>>,
    /// The record of the current turn.
    turn_record: Turn,
    overflow: TurnOverflow,
}

/// The iterations for which a turn requests permission.
enum IterationRequest {
    Any,
    /// Like `Any`, and in lockstep also a second one at the same instant: its input arrived after the first.
    Repeat,
    /// Only the first iteration since the instance became WINNER.
    First,
}

enum InstanceState {
    /// There is no instance: it was not created yet, or it faulted or was unloaded.
    Absent,
    Slept(Instance),
    Awake {
        instance: Instance,
        due: Nanos,
    },
    /// Between two of the others, within a turn.
    Changing,
}

impl Runner {
    pub(crate) fn new(engine: &Arc<Engine>, number: usize, build: Build, ports: Ports) -> Self {
        engine.builds.set_initial(number, Arc::new(build));
        Self::with_ports(engine, number, ports)
    }

    /// A runner of the build that is in force for the instance.
    fn with_ports(engine: &Arc<Engine>, number: usize, mut ports: Ports) -> Self {
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
            port_access: Arc::new(PortAccess::new(ports)),
            state: InstanceState::Absent,
            period: config.period_ns,
            anchor: 0,
            last_check: 0,
            last_iteration: 0,
            late: [false; 2],
            unloading: false,
            trial: None,
            takeover_pending: false,
            is_due_at_once: false,
            last_turn: 0,
            pace: DrawingPace::default(),
            journal,
            turn_record: Turn::new(Turn::CYCLED, number),
            overflow: TurnOverflow::default(),
        }
    }

    /// Creates the instance, unless there is one: before the application starts, so that a failure of the
    /// plugin is known at once, and after its instance was given up or unloaded.
    pub(crate) fn create(&mut self) -> Result<(), String> {
        if !matches!(self.state, InstanceState::Absent) {
            return Ok(());
        }
        let instance = self.create_instance(&self.engine.builds.current(self.number))?;
        self.engine.declare_panel(self.number, instance.panel());
        self.state = InstanceState::Slept(instance);
        self.engine.panels.add_instance(self.number);
        Ok(())
    }

    /// Creates an instance of that build with this runner's ports.
    fn create_instance(&self, build: &build::SharedBuild) -> Result<Instance, String> {
        self.engine.check_can_create(self.number)?;
        Instance::create(&self.engine, self.number, build, &self.port_access)
    }

    /// Like [`Self::create`], with a complete error.
    pub(crate) fn create_for_start(&mut self) -> Result<(), StartError> {
        self.create().map_err(|reason| {
            let application = &self.engine.application;
            let instance = &application.instances[self.number];
            let plugin = &application.plugins[instance.plugin].name;
            StartError::Create {
                schema: instance.name.clone(),
                type_name: format!("{plugin}/{}", instance.schema.name),
                reason,
            }
        })
    }

    /// Takes a turn if it is due now. Returns when the next turn is due; `None` if only a signal causes one.
    pub(crate) fn take_turn(&mut self, inbox: Inbox) -> Option<Nanos> {
        let (triggered, promoted, touched) = (inbox.triggered, inbox.promoted, inbox.gesture_queued);
        if !inbox.is_empty() {
            self.process_signals(inbox);
        }
        let mut has_run = false;
        if let InstanceState::Awake { due, .. } = self.state {
            let now = self.engine.clock.now();
            self.begin_turn(Turn::new(Turn::CYCLED, self.number));
            has_run = if now >= due {
                self.run_cycle(now, due);
                true
            } else if triggered || promoted && self.engine.rules.is_taking(self.number) {
                // The values behind the choice may be a period old, so it checks again before it acts (R8).
                self.react(now);
                true
            } else {
                false
            };
            self.record_turn();
            if has_run {
                self.draw();
            }
            self.release_values();
        }
        if touched {
            self.take_gesture();
        }
        self.end_turn(has_run);
        match self.state {
            InstanceState::Awake { due, .. } => Some(due),
            InstanceState::Slept(_) if self.engine.clock.is_real() => self.draw_asleep(),
            InstanceState::Absent | InstanceState::Slept(_) | InstanceState::Changing => None,
        }
    }

    /// Processes the signals, before anything is checked.
    fn process_signals(&mut self, inbox: Inbox) {
        for (group, ticket, level) in inbox.arbitration_requests {
            self.arbitrate(group, ticket, &level);
        }
        if inbox.replaced {
            if self.trial.is_some() {
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

    /// One period: check, then iterate if it is WINNER.
    fn run_cycle(&mut self, start: Nanos, due: Nanos) {
        self.is_due_at_once = false;
        self.check_and_iterate(start, IterationRequest::Any);
        let end = self.engine.clock.now();
        self.engine.metrics[self.number].record_cycle(start, end - start);
        let missed = self.schedule_next(due, end);
        if self.engine.clock.is_real() {
            self.record_cycle_time(end - start, missed);
        }
    }

    /// Reacts to a value that cannot wait for the period. A motor schema re-evaluates its precondition (R12),
    /// and iterates only if that made it WINNER. A driver carries out the command.
    fn react(&mut self, now: Nanos) {
        let motor = self.kind == Kind::Motor;
        self.check_and_iterate(
            now,
            if motor {
                IterationRequest::First
            } else {
                IterationRequest::Repeat
            },
        );
    }

    /// Evaluates the precondition of a motor schema, and iterates if the rules permit.
    fn check_and_iterate(&mut self, now: Nanos, request: IterationRequest) {
        let InstanceState::Awake { instance, .. } = &mut self.state else {
            return;
        };
        let checked = if self.kind == Kind::Motor {
            let result = instance.check();
            self.turn_record.looked = instance.copy_last_call(&mut self.turn_record, &mut self.overflow);
            let Some(check) = self.handle_check_result(now, result) else {
                return;
            };
            Some(check)
        } else {
            None
        };
        let has_iterated_now = self.last_iteration == now + 1 && !self.engine.clock.is_real();
        let requests_iteration = matches!(request, IterationRequest::Repeat) || !has_iterated_now;
        let first = matches!(request, IterationRequest::First);
        let (is_permitted, begun) = match checked {
            Some(check) if requests_iteration => {
                let (checked, begun) = self
                    .engine
                    .rules
                    .report_check_and_request(self.number, check, first);
                self.turn_record.checked = checked;
                begun
            }
            Some(check) => {
                self.turn_record.checked = self.engine.rules.report_check(self.number, check);
                return;
            }
            None if requests_iteration => self.engine.rules.request_iteration(self.number),
            None => return,
        };
        self.turn_record.begun = begun;
        self.turn_record.way = match request {
            IterationRequest::Any | IterationRequest::Repeat => Turn::ANY,
            IterationRequest::First => Turn::FIRST,
        };
        if is_permitted {
            self.last_iteration = now + 1;
            let result = self.iterate();
            self.finish_iteration(result);
        }
    }

    /// Converts the result of a check for the rules. Returns `None` after a failure, which it reports.
    fn handle_check_result(
        &mut self,
        now: Nanos,
        result: Result<instance::CheckResult, String>,
    ) -> Option<Check> {
        match result {
            Ok(result) => {
                // The newest value read caused the situation, but not before the last check, which read the
                // earlier values.
                let cause = result.newest.clamp(self.last_check.min(now), now);
                self.last_check = now;
                Some(Check {
                    ready: result.ready,
                    urgency: result.urgency,
                    cause,
                })
            }
            Err(reason) => {
                self.fault(reason);
                None
            }
        }
    }

    fn iterate(&mut self) -> Result<(), String> {
        let InstanceState::Awake { instance, .. } = &mut self.state else {
            return Ok(());
        };
        let start = self.engine.clock.now();
        let result = instance.iterate();
        self.turn_record.acted = instance.copy_last_call(&mut self.turn_record, &mut self.overflow);
        let took = self.engine.clock.now().saturating_sub(start);
        self.engine.metrics[self.number].record_iteration(took);
        result
    }

    /// Reports the end of an iteration to the rules.
    fn finish_iteration(&mut self, result: Result<(), String>) {
        match result {
            Ok(()) => self.engine.metrics[self.number].started.store(true, Relaxed),
            Err(reason) => self.fault(reason),
        }
        self.turn_record.ended = self.engine.rules.report_iteration_end(self.number);
    }

    /// Records the turn that has ended, if there was one.
    fn record_turn(&mut self) {
        if let Some(journal) = &self.journal {
            let turn = std::mem::replace(&mut self.turn_record, Turn::new(Turn::CYCLED, self.number));
            if !turn.is_empty() {
                journal.forward_with_ports(&turn, &self.overflow.ports);
            }
            self.overflow.ports.clear();
        }
    }

    /// Starts the record of a turn.
    fn begin_turn(&mut self, turn: Turn) {
        if self.journal.is_some() {
            self.turn_record = turn;
            self.overflow.ports.clear();
        }
    }

    /// Releases the values read, so that the next turn sees the newest.
    fn release_values(&mut self) {
        if let InstanceState::Awake { instance, .. } = &mut self.state {
            instance.release_values();
        }
    }

    fn arbitrate(&mut self, group: GroupId, ticket: u64, level: &Level) {
        self.turn_record = Turn {
            detail: u64::from(group.0),
            ticket,
            ..Turn::new(Turn::ARBITRATED, self.number)
        };
        self.engine.metrics[self.number].begin_arbitration(ticket, self.engine.clock.now());
        let reply = self.call_arbitration(level);
        let failed = match &reply {
            ArbitrationReply::Failed { reason } => Some(reason.clone()),
            ArbitrationReply::Chosen { .. } => None,
        };
        self.turn_record.checked = self.engine.rules.report_arbitration(group, ticket, reply);
        self.record_turn();
        if let Some(reason) = failed
            && !self.roll_back(&reason)
        {
            self.handle_failed_call(&reason);
        }
    }

    /// Calls the father's own arbitration.
    fn call_arbitration(&mut self, level: &Level) -> ArbitrationReply {
        let (InstanceState::Slept(instance) | InstanceState::Awake { instance, .. }) = &mut self.state else {
            return ArbitrationReply::Failed {
                reason: "the father is not there".into(),
            };
        };
        let choice = instance.arbitrate(level);
        self.turn_record.looked = instance.copy_last_call(&mut self.turn_record, &mut self.overflow);
        let (role, reason) = match choice {
            Ok(choice) => choice,
            Err(reason) => return ArbitrationReply::Failed { reason },
        };
        let children = &self.engine.application.instances[self.number].children;
        let child = role
            .and_then(|role| children[role])
            .map(|child| jde_core::SchemaId(child as u32));
        match (role, child) {
            (Some(role), None) => ArbitrationReply::Failed {
                reason: format!("chose the unbound child {role}"),
            },
            _ => ArbitrationReply::Chosen { child, reason },
        }
    }
}
