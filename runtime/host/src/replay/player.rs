//! Takes the recorded steps in their order. The consequences of a step wait for the step that the recording
//! contains for them. Those without a recorded step take effect on their own, after the slack.

use std::collections::BTreeSet;
use std::sync::Arc;

use jde_app::InstancePort;
use jde_core::{Nanos, Operator, SchemaId, Table};
use jde_records::turn::{FatherOperation, Operation, RecordedTurn, TurnKind, WrittenPort};

use super::recorded_inputs::RecordedInputs;
use super::recorded_run::{RecordedRun, ReplayStep, StepKind};
use super::slot::{PendingArbitration, ReplaySlot};
use super::writes::{PairedWrite, WriteMatcher};
use super::{PortReading, format_value};
use crate::engine::{Engine, Notifier, Signal};
use crate::exec::lockstep::SignalQueue;
use crate::inbox::Inbox;
use crate::instance::ShownValue;
use crate::runner::Runner;
use crate::sensor_fault::SensorFault;

/// The largest value that is formatted, in bytes.
const MAX_FORMATTED_BYTES: usize = 64;

/// Takes recorded turns again.
pub(super) struct Player {
    engine: Arc<Engine>,
    queue: Arc<SignalQueue>,
    slots: Table<SchemaId, Option<ReplaySlot>>,
    recorded_run: Box<dyn RecordedRun>,
    next: Option<ReplayStep>,
    slack: Nanos,
    inputs: RecordedInputs,
    unknown: BTreeSet<String>,
    writes: WriteMatcher,
    /// The recording has no further step, or its end was reached.
    is_finished: bool,
    is_shut_down: bool,
}

impl Player {
    pub(super) fn new(
        engine: Arc<Engine>,
        runners: Table<SchemaId, Option<Runner>>,
        recorded_run: Box<dyn RecordedRun>,
        slack: Nanos,
    ) -> Result<Self, String> {
        let queue = Arc::new(SignalQueue::default());
        let notifier: Arc<dyn Notifier> = Arc::clone(&queue) as _;
        engine.attach(&notifier);
        let mut slots: Table<SchemaId, _> = runners
            .into_iter()
            .map(|runner| runner.map(ReplaySlot::new))
            .collect();
        let inputs = RecordedInputs::new(&engine, slots.iter_mut().flatten())?;
        Ok(Self {
            engine,
            queue,
            slots,
            recorded_run,
            next: None,
            slack,
            inputs,
            unknown: BTreeSet::new(),
            writes: WriteMatcher::default(),
            is_finished: false,
            is_shut_down: false,
        })
    }

    pub(super) fn engine(&self) -> &Arc<Engine> {
        &self.engine
    }

    pub(super) fn step(&mut self) -> bool {
        if let Some(step) = self.next.take().or_else(|| self.recorded_run.next()) {
            if let Some(time) = self.next_unrecorded_time().filter(|time| *time < step.time) {
                self.next = Some(step);
                self.inputs.publish(&mut *self.recorded_run, time);
                self.engine.clock.set_exactly(time);
                self.take_unrecorded_step(time);
            } else {
                self.inputs.publish(&mut *self.recorded_run, step.time);
                self.engine.clock.set_exactly(step.clock());
                self.apply_step(&step);
                self.complete_step(&step);
            }
            self.settle();
            self.writes.pair_unrecorded(&self.engine, &mut self.slots);
        } else {
            self.is_finished = true;
        }
        !self.is_finished
    }

    pub(super) fn last_inputs(&self, schema: SchemaId) -> Vec<PortReading> {
        let ports = &self.engine.application.instances[schema].schema.ports;
        let Some(slot) = &self.slots[schema] else {
            return Vec::new();
        };
        let readings = ports.iter().zip(&slot.last_inputs).filter_map(|(port, input)| {
            let value = match input {
                ShownValue::NotRead => return None,
                ShownValue::NoValue => None,
                ShownValue::Value(shown) => {
                    let is_short = shown.bytes().len() <= MAX_FORMATTED_BYTES;
                    let text = is_short.then(|| format_value(&port.value_type, shown.bytes()));
                    Some((shown.stamp.sequence, shown.stamp.time, text))
                }
            };
            Some(PortReading {
                port: port.name.clone(),
                value,
            })
        });
        readings.collect()
    }

    /// Returns the schemas' writes since the last call, paired with the recorded writes.
    pub(super) fn take_writes(&mut self) -> Vec<PairedWrite> {
        self.writes.take()
    }

    pub(super) fn missed_values(&self) -> Vec<(String, u64)> {
        self.inputs.missed_values()
    }

    pub(super) fn unknown_writes(&self) -> Vec<String> {
        self.unknown.iter().cloned().collect()
    }

    /// Returns the time of the next step that the recording does not contain.
    fn next_unrecorded_time(&self) -> Option<Nanos> {
        let with_slack = |since: Nanos| since.saturating_add(self.slack);
        let timer = self.engine.rules.next_timer().map(with_slack);
        let slots = self.slots.iter().flatten();
        let waiting = slots
            .clone()
            .filter_map(ReplaySlot::waiting_since)
            .map(with_slack);
        let due = slots.filter_map(|slot| slot.due);
        timer.into_iter().chain(waiting).chain(due).min()
    }

    /// Takes the step that is due by [`Self::next_unrecorded_time`].
    fn take_unrecorded_step(&mut self, now: Nanos) {
        if self
            .engine
            .rules
            .next_timer()
            .is_some_and(|timer| timer.saturating_add(self.slack) <= now)
        {
            self.engine.tick();
            return;
        }
        for number in self.slots.ids() {
            let slack = self.slack;
            let Some(slot) = &mut self.slots[number] else {
                continue;
            };
            if slot
                .waiting_since()
                .is_some_and(|since| since.saturating_add(slack) <= now)
            {
                while let Some((awake, _)) = slot.transitions.pop_front() {
                    slot.apply_transition(awake, now);
                }
                slot.arbitrate_all();
                return self.settle();
            }
            if slot.due.is_some_and(|due| due <= now) {
                slot.due = slot.runner.take_turn(None);
                return self.settle();
            }
        }
    }

    /// Carries out the consequences of the last step, as far as the recording has no step for them.
    fn settle(&mut self) {
        let now = self.engine.clock.now();
        while let Some((number, signal)) = self.queue.pop() {
            let Some(slot) = &mut self.slots[number] else {
                continue;
            };
            match signal {
                Signal::Awake(_) if slot.was_awake && slot.transitions.is_empty() => {
                    slot.apply_transition(true, now)
                }
                Signal::Awake(_) => slot.transitions.push_back((true, now)),
                Signal::Asleep if slot.was_awake && slot.follows_recording => {
                    slot.transitions.push_back((false, now))
                }
                Signal::Asleep if slot.transitions.is_empty() => slot.apply_transition(false, now),
                Signal::Asleep => slot.transitions.push_back((false, now)),
                Signal::Replaced => slot.runner.give_up(),
                Signal::Unloaded => slot.runner.unload(),
                Signal::PeriodChanged => slot.runner.retime(),
                // A replay has no viewers and no operators.
                Signal::PanelOpened | Signal::GestureQueued | Signal::BuildPending => {}
                // The recording has the turn.
                Signal::TurnRequested => {}
                Signal::ArbitrationRequested { group, ticket, level } => {
                    let since = now;
                    slot.arbitrations.push(PendingArbitration {
                        since,
                        group,
                        ticket,
                        level,
                    });
                }
                signal @ (Signal::Promoted | Signal::Triggered) => {
                    if slot.due.is_some() {
                        let mut inbox = Inbox::default();
                        inbox.push(signal);
                        slot.due = slot.runner.take_turn(Some(inbox));
                    }
                }
            }
        }
    }

    fn apply_step(&mut self, step: &ReplayStep) {
        let turn = &*step.turn;
        let id = SchemaId(turn.schema);
        match turn.kind() {
            TurnKind::Started => self.engine.rules.start(),
            TurnKind::Ticked => self.engine.tick(),
            TurnKind::Operated(operation) => self.apply_operation(id, operation, turn),
            TurnKind::GivenUp => {
                let reason = "did not return from a call in the recording";
                self.engine.report_hung_call(id, reason.to_owned());
            }
            TurnKind::Ended => self.is_finished = true,
            TurnKind::FatherActed(operation) => self.apply_father_operation(id, operation),
            TurnKind::CommandRefused => {
                if let Some(slot) = self.slots.get(id).and_then(Option::as_ref) {
                    slot.runner.repeat_refusal();
                }
            }
            TurnKind::Awoke
            | TurnKind::Slept
            | TurnKind::Cycled(_)
            | TurnKind::Arbitrated { .. }
            | TurnKind::Touched { .. } => {
                if matches!(step.kind, StepKind::CheckCall | StepKind::IterationCall) {
                    self.publish_inputs(id, turn);
                }
                self.apply_schema_step(id, step);
            }
            TurnKind::Reloaded(_) | TurnKind::MorePorts { .. } | TurnKind::Unknown => {}
        }
    }

    /// Completes a step. After the last step of a turn, its writes are known and paired.
    fn complete_step(&mut self, step: &ReplayStep) {
        let is_schema_turn = matches!(
            step.turn.kind(),
            TurnKind::Awoke
                | TurnKind::Slept
                | TurnKind::Cycled(_)
                | TurnKind::Arbitrated { .. }
                | TurnKind::Touched { .. }
        );
        let id = SchemaId(step.turn.schema);
        let slot = self.slots.get_mut(id).and_then(Option::as_mut);
        if let Some(slot) = slot.filter(|_| is_schema_turn) {
            slot.in_turn = !step.is_last;
            if step.is_last {
                self.writes
                    .pair_turn(&self.engine, id, slot, &step.turn, &mut *self.recorded_run);
            }
        }
    }

    fn apply_schema_step(&mut self, id: SchemaId, step: &ReplayStep) {
        let (engine, turn) = (&self.engine, &*step.turn);
        let now = engine.clock.now();
        let Some(slot) = self.slots.get_mut(id).and_then(Option::as_mut) else {
            return;
        };
        match (turn.kind(), step.kind) {
            (TurnKind::Awoke, StepKind::CheckCall) => {
                slot.was_awake = true;
                while let Some((awake, _)) = slot.transitions.pop_front() {
                    slot.runner.show_recorded(Some(turn).filter(|_| awake));
                    slot.apply_transition(awake, now);
                    slot.runner.show_recorded(None);
                }
                slot.follows_recording = true;
                slot.due = None;
            }
            (TurnKind::Slept, StepKind::CheckCall) => {
                slot.was_awake = false;
                while let Some((awake, _)) = slot.transitions.pop_front() {
                    slot.runner.show_recorded(Some(turn));
                    slot.apply_transition(awake, now);
                    slot.runner.show_recorded(None);
                }
                slot.follows_recording = false;
                slot.start_own_turns(now);
            }
            (TurnKind::Arbitrated { group }, StepKind::CheckCall) => {
                if let Some(request) = slot.take_arbitration(group, turn.ticket) {
                    slot.runner.show_recorded(Some(turn));
                    let reply = slot.runner.call_arbitration(&request.level);
                    slot.runner.show_recorded(None);
                    slot.arbitration_result = Some((request.group, request.ticket, reply));
                }
            }
            (TurnKind::Arbitrated { .. }, StepKind::Checked) => {
                if let Some((group, ticket, reply)) = slot.arbitration_result.take() {
                    engine.rules.report_arbitration(group, ticket, reply);
                }
            }
            (TurnKind::Touched { number: touched }, StepKind::CheckCall) => {
                match self.recorded_run.gesture(touched) {
                    Some((by, gesture)) => {
                        slot.runner.show_recorded(Some(turn));
                        slot.gesture_error = slot.runner.repeat_gesture(&by, &gesture).err();
                        slot.runner.show_recorded(None);
                        if turn.failed.order == 0 {
                            slot.report_gesture_error();
                        }
                    }
                    None => drop(self.unknown.insert(format!("the panel of {}", engine.name(id)))),
                }
            }
            (TurnKind::Touched { .. }, StepKind::Failed) => slot.report_gesture_error(),
            (TurnKind::Cycled(_), part) => {
                if slot.follows_recording {
                    slot.apply_cycle_step(engine, part, &step.turn);
                }
                if part == StepKind::Failed {
                    // The fault put it to sleep, so the recording has no step for falling asleep.
                    slot.was_awake = false;
                }
                if step.is_last {
                    slot.end_turn();
                }
            }
            _ => {}
        }
    }

    /// Applies a recorded action of a father on a child or a group, which he requested in his iteration.
    fn apply_father_operation(&mut self, father: SchemaId, operation: FatherOperation) {
        let permitted_turn = self
            .slots
            .get(father)
            .and_then(|slot| slot.as_ref()?.permitted_turn.clone());
        if let Some(turn) = permitted_turn {
            self.publish_inputs(father, &turn);
        }
        let Some(slot) = self.slots.get_mut(father).and_then(Option::as_mut) else {
            return;
        };
        slot.run_iteration(&self.engine);
        let mut actions = slot.father_actions.iter();
        if let Some(place) = actions.position(|action| action.operation() == operation) {
            // The requests before it had no effect in the recorded run.
            for action in slot.father_actions.drain(..=place) {
                self.engine.apply_father_action(action);
            }
        }
    }

    fn apply_operation(&mut self, id: SchemaId, operation: Operation, turn: &RecordedTurn) {
        let operators = &self.engine.operators;
        match operation {
            // The original operator was informed.
            Operation::Refused => {}
            Operation::Played(by) => operators.repeat_operation(by, Operator::Play(id)),
            Operation::Stopped(by) => operators.repeat_operation(by, Operator::Stop(id)),
            Operation::Forced(by) => operators.repeat_operation(by, Operator::Force(id)),
            Operation::Released(by) => operators.repeat_operation(by, Operator::Release(id)),
            Operation::Unloaded(by) => operators.repeat_unload(by, id),
            Operation::Loaded => operators.repeat_load(id),
            Operation::AllStopped(by) => operators.repeat_stop_all(by),
            Operation::AllReleased => operators.repeat_release_all(),
            Operation::Undone(by) => operators.repeat_undo(by, id),
            Operation::Debugged => self.engine.rules.set_debugged(id, true),
            Operation::WentOn => self.engine.rules.set_debugged(id, false),
            Operation::FailedExport { port } => {
                let fault = SensorFault::from_words(&turn.ports);
                operators.repeat_export(id, port as usize, fault, turn.checked.time);
            }
            Operation::RepairedExport { port } => {
                operators.repeat_export(id, port as usize, None, turn.checked.time);
            }
            Operation::Wrote(port) => self.apply_write(id, port, turn),
        }
    }

    fn apply_write(&mut self, number: SchemaId, port: WrittenPort, turn: &RecordedTurn) {
        let Some(instance) = self.engine.application.instances.get(number) else {
            return;
        };
        let variable = match port {
            WrittenPort::Period => Some(Arc::clone(self.engine.variables.period(number))),
            WrittenPort::Port(port) => {
                let port = InstancePort::new(number, port as usize);
                self.engine.variables.of(port).cloned()
            }
        };
        let Some(variable) = variable else {
            return;
        };
        let name = variable.describe().full_name();
        debug_assert!(name.starts_with(&instance.name));
        match self.recorded_run.written_value(&name, turn.port(0)) {
            Some(bytes) => self.engine.operators.repeat_write(&variable, &bytes),
            None => drop(self.unknown.insert(name)),
        }
    }

    fn publish_inputs(&mut self, number: SchemaId, turn: &RecordedTurn) {
        if let Some(instance) = self.engine.application.instances.get(number) {
            self.inputs
                .publish_inputs(&mut *self.recorded_run, instance, turn);
        }
    }

    fn shut_down(&mut self) {
        self.engine.rules.brake_all();
        for number in self.engine.rules.put_to_sleep() {
            if let Some(slot) = &mut self.slots[number] {
                slot.runner.fall_asleep();
            }
        }
        while self.queue.pop().is_some() {}
        self.slots
            .iter_mut()
            .rev()
            .flatten()
            .for_each(|slot| slot.runner.destroy());
    }
}

impl Drop for Player {
    fn drop(&mut self) {
        if !std::mem::replace(&mut self.is_shut_down, true) {
            self.shut_down();
        }
    }
}
