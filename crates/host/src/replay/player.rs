//! Takes the steps of the past in their order. The consequences of a step wait for the step that the past
//! contains for them. Those without a recorded step take effect on their own, after the slack.

use std::collections::BTreeSet;
use std::sync::Arc;

use jde_core::{Nanos, Operator, SchemaId};
use jde_records::turn::{RecordedTurn, Turn};

use super::recorded_inputs::RecordedInputs;
use super::recorded_run::{RecordedRun, ReplayStep, StepKind};
use super::slot::{PendingArbitration, ReplaySlot};
use super::writes::{PairedWrite, WriteMatcher};
use super::{PortReading, format_value as in_words};
use crate::engine::{Engine, Notifier, Signal};
use crate::exec::lockstep::SignalQueue;
use crate::inbox::Inbox;
use crate::instance::ShownValue;
use crate::runner::Runner;

/// The largest value that is formatted in words, in bytes.
const MAX_FORMATTED_BYTES: usize = 64;

/// Takes recorded turns again.
pub(super) struct Player {
    engine: Arc<Engine>,
    queue: Arc<SignalQueue>,
    slots: Vec<Option<ReplaySlot>>,
    recorded_run: Box<dyn RecordedRun>,
    next: Option<ReplayStep>,
    slack: Nanos,
    inputs: RecordedInputs,
    unknown: BTreeSet<String>,
    writes: WriteMatcher,
    /// The past has no further step, or its end was reached.
    is_finished: bool,
    is_shut_down: bool,
}

impl Player {
    pub(super) fn new(
        engine: Arc<Engine>,
        runners: Vec<Option<Runner>>,
        past: Box<dyn RecordedRun>,
        slack: Nanos,
    ) -> Result<Self, String> {
        let queue = Arc::new(SignalQueue::default());
        let bells: Arc<dyn Notifier> = Arc::clone(&queue) as _;
        engine.attach(&bells);
        let mut seats: Vec<_> = runners
            .into_iter()
            .map(|runner| runner.map(ReplaySlot::new))
            .collect();
        let scenery = RecordedInputs::new(&engine, seats.iter_mut().flatten())?;
        Ok(Self {
            engine,
            queue,
            slots: seats,
            recorded_run: past,
            next: None,
            slack,
            inputs: scenery,
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

    pub(super) fn last_inputs(&self, schema: usize) -> Vec<PortReading> {
        let ports = &self.engine.application.instances[schema].schema.ports;
        let Some(seat) = &self.slots[schema] else {
            return Vec::new();
        };
        let sights = ports.iter().zip(&seat.last_inputs).filter_map(|(port, shown)| {
            let value = match shown {
                ShownValue::NotRead => return None,
                ShownValue::NoValue => None,
                ShownValue::Value(old) => {
                    let short = old.bytes().len() <= MAX_FORMATTED_BYTES;
                    let words = short.then(|| in_words(&port.value_type, old.bytes()));
                    Some((old.stamp.sequence, old.stamp.time, words))
                }
            };
            Some(PortReading {
                port: port.name.clone(),
                value,
            })
        });
        sights.collect()
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

    /// Returns the time of the next step that the past does not contain.
    fn next_unrecorded_time(&self) -> Option<Nanos> {
        let late = |since: Nanos| since.saturating_add(self.slack);
        let timer = self.engine.next_timer().map(late);
        let seats = self.slots.iter().flatten();
        let waiting = seats.clone().filter_map(ReplaySlot::waiting_since).map(late);
        let due = seats.filter_map(|seat| seat.due);
        timer.into_iter().chain(waiting).chain(due).min()
    }

    /// Takes the step that is due by [`Self::next_unrecorded_time`].
    fn take_unrecorded_step(&mut self, now: Nanos) {
        if self
            .engine
            .next_timer()
            .is_some_and(|timer| timer.saturating_add(self.slack) <= now)
        {
            self.engine.tick();
            return;
        }
        for number in 0..self.slots.len() {
            let slack = self.slack;
            let Some(seat) = &mut self.slots[number] else {
                continue;
            };
            if seat
                .waiting_since()
                .is_some_and(|since| since.saturating_add(slack) <= now)
            {
                while let Some((awake, _)) = seat.transitions.pop_front() {
                    seat.apply_transition(awake, now);
                }
                seat.arbitrate_all();
                return self.settle();
            }
            if seat.due.is_some_and(|due| due <= now) {
                seat.due = seat.runner.take_turn(Inbox::default());
                return self.settle();
            }
        }
    }

    /// Carries out the consequences of the last step, as far as the past has no step for them.
    fn settle(&mut self) {
        let now = self.engine.clock.now();
        while let Some((number, signal)) = self.queue.pop() {
            let Some(seat) = &mut self.slots[number] else {
                continue;
            };
            match signal {
                Signal::Awake(_) if seat.was_awake && seat.transitions.is_empty() => {
                    seat.apply_transition(true, now)
                }
                Signal::Awake(_) => seat.transitions.push_back((true, now)),
                Signal::Asleep if seat.was_awake && seat.follows_recording => {
                    seat.transitions.push_back((false, now))
                }
                Signal::Asleep if seat.transitions.is_empty() => seat.apply_transition(false, now),
                Signal::Asleep => seat.transitions.push_back((false, now)),
                Signal::Replaced => seat.runner.give_up_now(),
                Signal::Unloaded => seat.runner.unload_now(),
                Signal::PeriodChanged => seat.runner.retime_now(),
                // A replay has no viewers and no operators.
                Signal::PanelOpened | Signal::GestureQueued | Signal::BuildPending => {}
                Signal::ArbitrationRequested { group, ticket, level } => {
                    let since = now;
                    seat.arbitrations.push(PendingArbitration {
                        since,
                        group,
                        ticket,
                        level,
                    });
                }
                signal @ (Signal::Promoted | Signal::Triggered) => {
                    if seat.due.is_some() {
                        let mut inbox = Inbox::default();
                        inbox.push(signal);
                        seat.due = seat.runner.take_turn(inbox);
                    }
                }
            }
        }
    }

    fn apply_step(&mut self, step: &ReplayStep) {
        let turn = &*step.turn;
        let number = turn.schema as usize;
        match turn.kind {
            Turn::STARTED => self.engine.start(),
            Turn::TICKED => self.engine.tick(),
            Turn::OPERATED => self.apply_operator_action(number, turn),
            Turn::GIVEN_UP => {
                let reason = "did not return from a call in the recording";
                self.engine.report_hung_call(number, reason.to_owned());
            }
            Turn::ENDED => self.is_finished = true,
            Turn::FATHER_ACTED => self.apply_father_action(number, turn),
            _ => {
                if matches!(step.kind, StepKind::CheckCall | StepKind::IterationCall) {
                    self.publish_inputs(number, turn);
                }
                self.apply_schema_step(number, step);
            }
        }
    }

    /// Completes a step. After the last step of a turn, its writes are known and paired.
    fn complete_step(&mut self, step: &ReplayStep) {
        let is_schemas = matches!(
            step.turn.kind,
            Turn::AWOKE | Turn::SLEPT | Turn::CYCLED | Turn::ARBITRATED | Turn::TOUCHED
        );
        let number = step.turn.schema as usize;
        let seat = self.slots.get_mut(number).and_then(Option::as_mut);
        if let Some(seat) = seat.filter(|_| is_schemas) {
            seat.in_turn = !step.is_last;
            if step.is_last {
                self.writes
                    .pair_turn(&self.engine, number, seat, &step.turn, &mut *self.recorded_run);
            }
        }
    }

    fn apply_schema_step(&mut self, number: usize, step: &ReplayStep) {
        let (engine, turn) = (&self.engine, &*step.turn);
        let now = engine.clock.now();
        let Some(seat) = self.slots.get_mut(number).and_then(Option::as_mut) else {
            return;
        };
        match (turn.kind, step.kind) {
            (Turn::AWOKE, StepKind::CheckCall) => {
                seat.was_awake = true;
                while let Some((awake, _)) = seat.transitions.pop_front() {
                    seat.runner.show_recorded(Some(turn).filter(|_| awake));
                    seat.apply_transition(awake, now);
                    seat.runner.show_recorded(None);
                }
                seat.follows_recording = true;
                seat.due = None;
            }
            (Turn::SLEPT, StepKind::CheckCall) => {
                seat.was_awake = false;
                while let Some((awake, _)) = seat.transitions.pop_front() {
                    seat.runner.show_recorded(Some(turn));
                    seat.apply_transition(awake, now);
                    seat.runner.show_recorded(None);
                }
                seat.follows_recording = false;
                seat.start_own_turns(now);
            }
            (Turn::ARBITRATED, StepKind::CheckCall) => {
                if let Some(asked) = seat.take_arbitration(turn) {
                    seat.runner.show_recorded(Some(turn));
                    let answer = seat.runner.repeat_arbitration(&asked.level);
                    seat.runner.show_recorded(None);
                    seat.arbitration_result = Some((asked.group, asked.ticket, answer));
                }
            }
            (Turn::ARBITRATED, StepKind::Checked) => {
                if let Some((group, ticket, answer)) = seat.arbitration_result.take() {
                    engine.report_arbitration(group, ticket, answer);
                }
            }
            (Turn::TOUCHED, StepKind::CheckCall) => match self.recorded_run.gesture(turn.detail) {
                Some((by, gesture)) => {
                    seat.runner.show_recorded(Some(turn));
                    seat.gesture_error = seat.runner.repeat_gesture(&by, &gesture).err();
                    seat.runner.show_recorded(None);
                    if turn.failed.order == 0 {
                        seat.report_gesture_error();
                    }
                }
                None => drop(
                    self.unknown
                        .insert(format!("the panel of {}", engine.name(number))),
                ),
            },
            (Turn::TOUCHED, StepKind::Failed) => seat.report_gesture_error(),
            (Turn::CYCLED, part) => {
                if seat.follows_recording {
                    seat.apply_cycle_step(engine, part, &step.turn);
                }
                if part == StepKind::Failed {
                    // The fault put it to sleep, so the past has no step for falling asleep.
                    seat.was_awake = false;
                }
                if step.is_last {
                    seat.end_turn();
                }
            }
            _ => {}
        }
    }

    /// Takes a recorded action of a father on a child or a group, which it requested in its iteration.
    fn apply_father_action(&mut self, father: usize, turn: &Turn) {
        let under_way = self
            .slots
            .get(father)
            .and_then(|seat| seat.as_ref()?.permitted_turn.clone());
        if let Some(under_way) = under_way {
            self.publish_inputs(father, &under_way);
        }
        let Some(seat) = self.slots.get_mut(father).and_then(Option::as_mut) else {
            return;
        };
        seat.run_iteration(&self.engine);
        let mut leads = seat.father_actions.iter();
        if let Some(place) = leads.position(|led| led.encode() == (turn.way, turn.detail)) {
            // The requests before it had no effect in the past.
            for led in seat.father_actions.drain(..=place) {
                self.engine.apply_father_action(led);
            }
        }
    }

    fn apply_operator_action(&mut self, number: usize, turn: &RecordedTurn) {
        let id = SchemaId(turn.schema);
        match turn.way {
            Turn::PLAYED => self.engine.repeat_operation(Operator::Play(id)),
            Turn::STOPPED => self.engine.repeat_operation(Operator::Stop(id)),
            Turn::FORCED => self.engine.repeat_operation(Operator::Force(id)),
            Turn::RELEASED => self.engine.repeat_operation(Operator::Release(id)),
            Turn::UNLOADED => self.engine.repeat_unload(number),
            Turn::LOADED => self.engine.repeat_load(number),
            Turn::ALL_STOPPED => self.engine.repeat_stop_all(),
            Turn::ALL_RELEASED => self.engine.repeat_release_all(),
            Turn::UNDONE => self.engine.repeat_undo(number),
            Turn::WROTE => {
                let Some(instance) = self.engine.application.instances.get(number) else {
                    return;
                };
                let variable = match turn.detail {
                    Turn::PERIOD => Some(Arc::clone(self.engine.variables.period(number))),
                    port => self.engine.variables.of(number, port as usize).cloned(),
                };
                let Some(variable) = variable else {
                    return;
                };
                let name = variable.describe().full_name();
                debug_assert!(name.starts_with(&instance.name));
                match self.recorded_run.written_value(&name, turn.port(0)) {
                    Some(bytes) => self.engine.repeat_write(&variable, &bytes),
                    None => drop(self.unknown.insert(name)),
                }
            }
            _ => {}
        }
    }

    fn publish_inputs(&mut self, number: usize, turn: &RecordedTurn) {
        if let Some(instance) = self.engine.application.instances.get(number) {
            self.inputs
                .publish_inputs(&mut *self.recorded_run, instance, turn);
        }
    }

    fn shut_down(&mut self) {
        self.engine.brake_all();
        for number in self.engine.put_to_sleep() {
            if let Some(seat) = &mut self.slots[number] {
                seat.runner.sleep_now();
            }
        }
        while self.queue.pop().is_some() {}
        self.slots
            .iter_mut()
            .rev()
            .flatten()
            .for_each(|seat| seat.runner.destroy());
    }
}

impl Drop for Player {
    fn drop(&mut self) {
        if !std::mem::replace(&mut self.is_shut_down, true) {
            self.shut_down();
        }
    }
}
