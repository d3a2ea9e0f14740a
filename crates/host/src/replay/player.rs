//! Takes the steps of the past in their order. The consequences of a step wait for the step that the past
//! contains for them. Those without a recorded step take effect on their own, after the slack.

use std::collections::BTreeSet;
use std::sync::Arc;

use jde_core::{Nanos, Operator, SchemaId};

use super::deeds::{Deed, Deeds};
use super::past::{Part, Past, Step};
use super::scenery::Scenery;
use super::seat::{Asked, Seat};
use super::{Sight, words as in_words};
use crate::engine::{Bells, Engine, Signal};
use crate::exec::lockstep::Queue;
use crate::inbox::Inbox;
use crate::instance::Shown;
use crate::runner::Runner;
use crate::turn::{Told, Turn};

/// The largest value that is formatted in words, in bytes.
const SHORT: usize = 64;

/// Takes recorded turns again.
pub(super) struct Player {
    engine: Arc<Engine>,
    queue: Arc<Queue>,
    seats: Vec<Option<Seat>>,
    past: Box<dyn Past>,
    next: Option<Step>,
    slack: Nanos,
    scenery: Scenery,
    unknown: BTreeSet<String>,
    deeds: Deeds,
    /// The past has no further step, or its end was reached.
    over: bool,
    resting: bool,
}

impl Player {
    pub(super) fn new(
        engine: Arc<Engine>,
        runners: Vec<Option<Runner>>,
        past: Box<dyn Past>,
        slack: Nanos,
    ) -> Result<Self, String> {
        let queue = Arc::new(Queue::default());
        let bells: Arc<dyn Bells> = Arc::clone(&queue) as _;
        engine.attach(&bells);
        let mut seats: Vec<_> = runners.into_iter().map(|runner| runner.map(Seat::new)).collect();
        let scenery = Scenery::new(&engine, seats.iter_mut().flatten())?;
        Ok(Self {
            engine,
            queue,
            seats,
            past,
            next: None,
            slack,
            scenery,
            unknown: BTreeSet::new(),
            deeds: Deeds::default(),
            over: false,
            resting: false,
        })
    }

    pub(super) fn engine(&self) -> &Arc<Engine> {
        &self.engine
    }

    pub(super) fn step(&mut self) -> bool {
        if let Some(step) = self.next.take().or_else(|| self.past.next()) {
            if let Some(time) = self.own_time().filter(|time| *time < step.time) {
                self.next = Some(step);
                self.scenery.publish(&mut *self.past, time);
                self.engine.clock.put(time);
                self.own(time);
            } else {
                self.scenery.publish(&mut *self.past, step.time);
                self.engine.clock.put(step.clock());
                self.take(&step);
                self.done(&step);
            }
            self.settle();
            self.deeds.told_of_none(&self.engine, &mut self.seats);
        } else {
            self.over = true;
        }
        !self.over
    }

    pub(super) fn saw(&self, schema: usize) -> Vec<Sight> {
        let ports = &self.engine.application.instances[schema].schema.ports;
        let Some(seat) = &self.seats[schema] else {
            return Vec::new();
        };
        let sights = ports.iter().zip(&seat.saw).filter_map(|(port, shown)| {
            let value = match shown {
                Shown::Unseen => return None,
                Shown::Nothing => None,
                Shown::Value(old) => {
                    let short = old.bytes().len() <= SHORT;
                    let words = short.then(|| in_words(&port.value_type, old.bytes()));
                    Some((old.stamp.sequence, old.stamp.time, words))
                }
            };
            Some(Sight {
                port: port.name.clone(),
                value,
            })
        });
        sights.collect()
    }

    /// Returns the schemas' writes since the last call, paired with the recorded writes.
    pub(super) fn deeds(&mut self) -> Vec<Deed> {
        self.deeds.take()
    }

    pub(super) fn missed(&self) -> Vec<(String, u64)> {
        self.scenery.missed()
    }

    pub(super) fn unknown(&self) -> Vec<String> {
        self.unknown.iter().cloned().collect()
    }

    /// Returns the time of the next step that the past does not contain.
    fn own_time(&self) -> Option<Nanos> {
        let late = |since: Nanos| since.saturating_add(self.slack);
        let timer = self.engine.next_timer().map(late);
        let seats = self.seats.iter().flatten();
        let waiting = seats.clone().filter_map(Seat::waits_since).map(late);
        let due = seats.filter_map(|seat| seat.due);
        timer.into_iter().chain(waiting).chain(due).min()
    }

    /// Takes the step that is due by [`Self::own_time`].
    fn own(&mut self, now: Nanos) {
        if self
            .engine
            .next_timer()
            .is_some_and(|timer| timer.saturating_add(self.slack) <= now)
        {
            self.engine.tick();
            return;
        }
        for number in 0..self.seats.len() {
            let slack = self.slack;
            let Some(seat) = &mut self.seats[number] else {
                continue;
            };
            if seat
                .waits_since()
                .is_some_and(|since| since.saturating_add(slack) <= now)
            {
                while let Some((awake, _)) = seat.life.pop_front() {
                    seat.live(awake, now);
                }
                seat.answer_all();
                return self.settle();
            }
            if seat.due.is_some_and(|due| due <= now) {
                seat.due = seat.runner.turn(Inbox::default());
                return self.settle();
            }
        }
    }

    /// Carries out the consequences of the last step, as far as the past has no step for them.
    fn settle(&mut self) {
        let now = self.engine.clock.now();
        while let Some((number, signal)) = self.queue.pop() {
            let Some(seat) = &mut self.seats[number] else {
                continue;
            };
            match signal {
                Signal::Awake(_) if seat.was_awake && seat.life.is_empty() => seat.live(true, now),
                Signal::Awake(_) => seat.life.push_back((true, now)),
                Signal::Asleep if seat.was_awake && seat.told => seat.life.push_back((false, now)),
                Signal::Asleep if seat.life.is_empty() => seat.live(false, now),
                Signal::Asleep => seat.life.push_back((false, now)),
                Signal::Replaced => seat.runner.give_up_now(),
                Signal::Unloaded => seat.runner.unload_now(),
                Signal::Retimed => seat.runner.retime_now(),
                // A replay has no viewers and no operators.
                Signal::Looked | Signal::Touched | Signal::Swapped => {}
                Signal::Asked { group, ticket, level } => {
                    let since = now;
                    seat.asked.push(Asked {
                        since,
                        group,
                        ticket,
                        level,
                    });
                }
                signal @ (Signal::Promoted | Signal::Triggered) => {
                    if seat.due.is_some() {
                        let mut inbox = Inbox::default();
                        inbox.put(signal);
                        seat.due = seat.runner.turn(inbox);
                    }
                }
            }
        }
    }

    fn take(&mut self, step: &Step) {
        let turn = &*step.turn;
        let number = turn.schema as usize;
        match turn.kind {
            Turn::STARTED => self.engine.start(),
            Turn::TICKED => self.engine.tick(),
            Turn::OPERATED => self.operate(number, turn),
            Turn::GIVEN_UP => {
                let reason = "did not return from a call in the recording";
                self.engine.hung(number, reason.to_owned());
            }
            Turn::ENDED => self.over = true,
            Turn::LED => self.lead(number, turn),
            _ => {
                if matches!(step.part, Part::Looked | Part::Acted) {
                    self.see_to(number, turn);
                }
                self.step_of(number, step);
            }
        }
    }

    /// Completes a step. After the last step of a turn, its writes are known and paired.
    fn done(&mut self, step: &Step) {
        let is_schemas = matches!(
            step.turn.kind,
            Turn::AWOKE | Turn::SLEPT | Turn::CYCLED | Turn::ARBITRATED | Turn::TOUCHED
        );
        let number = step.turn.schema as usize;
        let seat = self.seats.get_mut(number).and_then(Option::as_mut);
        if let Some(seat) = seat.filter(|_| is_schemas) {
            seat.in_turn = !step.last;
            if step.last {
                self.deeds
                    .told(&self.engine, number, seat, &step.turn, &mut *self.past);
            }
        }
    }

    fn step_of(&mut self, number: usize, step: &Step) {
        let (engine, turn) = (&self.engine, &*step.turn);
        let now = engine.clock.now();
        let Some(seat) = self.seats.get_mut(number).and_then(Option::as_mut) else {
            return;
        };
        match (turn.kind, step.part) {
            (Turn::AWOKE, Part::Looked) => {
                seat.was_awake = true;
                while let Some((awake, _)) = seat.life.pop_front() {
                    seat.runner.recall(Some(turn).filter(|_| awake));
                    seat.live(awake, now);
                    seat.runner.recall(None);
                }
                seat.told = true;
                seat.due = None;
            }
            (Turn::SLEPT, Part::Looked) => {
                seat.was_awake = false;
                while let Some((awake, _)) = seat.life.pop_front() {
                    seat.runner.recall(Some(turn));
                    seat.live(awake, now);
                    seat.runner.recall(None);
                }
                seat.told = false;
                seat.go_on(now);
            }
            (Turn::ARBITRATED, Part::Looked) => {
                if let Some(asked) = seat.question(turn) {
                    seat.runner.recall(Some(turn));
                    let answer = seat.runner.answer_again(&asked.level);
                    seat.runner.recall(None);
                    seat.answer = Some((asked.group, asked.ticket, answer));
                }
            }
            (Turn::ARBITRATED, Part::Checked) => {
                if let Some((group, ticket, answer)) = seat.answer.take() {
                    engine.answered(group, ticket, answer);
                }
            }
            (Turn::TOUCHED, Part::Looked) => match self.past.touched(turn.detail) {
                Some((by, gesture)) => {
                    seat.runner.recall(Some(turn));
                    seat.touched = seat.runner.touch_again(&by, &gesture).err();
                    seat.runner.recall(None);
                    if turn.failed.order == 0 {
                        seat.fail();
                    }
                }
                None => drop(
                    self.unknown
                        .insert(format!("the panel of {}", engine.name(number))),
                ),
            },
            (Turn::TOUCHED, Part::Failed) => seat.fail(),
            (Turn::CYCLED, part) => {
                if seat.told {
                    seat.cycle(engine, part, &step.turn);
                }
                if part == Part::Failed {
                    // The fault put it to sleep, so the past has no step for falling asleep.
                    seat.was_awake = false;
                }
                if step.last {
                    seat.rest();
                }
            }
            _ => {}
        }
    }

    /// Takes a recorded action of a father on a child or a group, which it requested in its iteration.
    fn lead(&mut self, father: usize, turn: &Turn) {
        let under_way = self
            .seats
            .get(father)
            .and_then(|seat| seat.as_ref()?.leave.clone());
        if let Some(under_way) = under_way {
            self.see_to(father, &under_way);
        }
        let Some(seat) = self.seats.get_mut(father).and_then(Option::as_mut) else {
            return;
        };
        seat.act(&self.engine);
        let mut leads = seat.leads.iter();
        if let Some(place) = leads.position(|led| led.told() == (turn.way, turn.detail)) {
            // The requests before it had no effect in the past.
            for led in seat.leads.drain(..=place) {
                self.engine.carry_on(led);
            }
        }
    }

    fn operate(&mut self, number: usize, turn: &Told) {
        let id = SchemaId(turn.schema);
        match turn.way {
            Turn::PLAYED => self.engine.operate_again(Operator::Play(id)),
            Turn::STOPPED => self.engine.operate_again(Operator::Stop(id)),
            Turn::FORCED => self.engine.operate_again(Operator::Force(id)),
            Turn::RELEASED => self.engine.operate_again(Operator::Release(id)),
            Turn::UNLOADED => self.engine.unload_again(number),
            Turn::LOADED => self.engine.load_again(number),
            Turn::ALL_STOPPED => self.engine.stop_all_again(),
            Turn::ALL_RELEASED => self.engine.release_all_again(),
            Turn::LET_GO => self.engine.let_go_again(number),
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
                match self.past.written(&name, turn.port(0)) {
                    Some(bytes) => self.engine.put_again(&variable, &bytes),
                    None => drop(self.unknown.insert(name)),
                }
            }
            _ => {}
        }
    }

    fn see_to(&mut self, number: usize, turn: &Told) {
        if let Some(instance) = self.engine.application.instances.get(number) {
            self.scenery.see_to(&mut *self.past, instance, turn);
        }
    }

    fn shut_down(&mut self) {
        self.engine.brake_all();
        for number in self.engine.put_to_sleep() {
            if let Some(seat) = &mut self.seats[number] {
                seat.runner.sleep_now();
            }
        }
        while self.queue.pop().is_some() {}
        self.seats
            .iter_mut()
            .rev()
            .flatten()
            .for_each(|seat| seat.runner.destroy());
    }
}

impl Drop for Player {
    fn drop(&mut self) {
        if !std::mem::replace(&mut self.resting, true) {
            self.shut_down();
        }
    }
}
