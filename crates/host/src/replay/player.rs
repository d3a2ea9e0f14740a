//! Takes the steps of the past in their order. What follows from one is left to the step that the past has for it; what it has
//! none for happens by itself, after the slack that threads need to tell of what they did.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::{Arc, Weak};

use jde_abi::describe::{Kind, Role};
use jde_board::{Reader, Stamp, Variable, Watch, Writer, value};
use jde_core::{Nanos, Operator, SchemaId};

use super::past::{Old, Part, Past, Step};
use super::seat::{Asked, Seat};
use super::{Sight, has};
use crate::app::{Application, Binding, Instance, Remote, Source as Origin};
use crate::engine::{Bells, Engine, Signal};
use crate::exec::lockstep::Queue;
use crate::history::History;
use crate::inbox::Inbox;
use crate::instance::Shown;
use crate::runner::Runner;
use crate::turn::{INPUTS, Turn};

/// Bytes of the largest value that is told in words.
const SHORT: usize = 64;

/// Takes the turns of the past again.
pub(super) struct Player {
    engine: Arc<Engine>,
    queue: Arc<Queue>,
    seats: Vec<Option<Seat>>,
    past: Box<dyn Past>,
    next: Option<Step>,
    slack: Nanos,
    sources: Vec<Export>,
    /// Of the same places.
    origins: Vec<Origin>,
    histories: BTreeMap<String, Arc<History>>,
    unknown: BTreeSet<String>,
    /// Its end has been told.
    over: bool,
    resting: bool,
    /// Kept for as long as histories grow.
    _watches: Vec<Watch>,
}

/// What a driver exported.
struct Export {
    writer: Writer,
    history: Arc<History>,
}

/// What schemas can import that no schema but a driver, or nobody here, makes.
pub(super) fn origins(application: &Application) -> Vec<Origin> {
    let instances = application.instances.iter().enumerate();
    let drivers = instances.filter(|(_, instance)| is_driver(instance));
    let exports = drivers.flat_map(|(number, instance)| {
        let ports = instance.schema.ports.iter().enumerate();
        let exports = ports.filter(|(_, port)| matches!(port.role, Role::Export));
        exports.map(move |(port, _)| Origin::Here(number, port))
    });
    let remotes = (0..application.remotes.len()).map(Origin::Elsewhere);
    exports.chain(remotes).collect()
}

pub(super) fn is_driver(instance: &Instance) -> bool {
    instance.schema.kind == Kind::Driver
}

/// Whether a schema that is no driver imports it.
pub(super) fn is_imported(application: &Application, origin: Origin) -> bool {
    let others = application.instances.iter().filter(|other| !is_driver(other));
    let mut bindings = others.flat_map(|other| &other.bindings);
    bindings
        .any(|binding| matches!(binding, Binding::Import { source: Some(source), .. } if *source == origin))
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
        let mut player = Self {
            seats: runners.into_iter().map(|runner| runner.map(Seat::new)).collect(),
            engine,
            queue,
            past,
            next: None,
            slack,
            sources: Vec::new(),
            origins: Vec::new(),
            histories: BTreeMap::new(),
            unknown: BTreeSet::new(),
            over: false,
            resting: false,
            _watches: Vec::new(),
        };
        player.find_sources()?;
        player.look_back();
        Ok(player)
    }

    pub(super) fn engine(&self) -> &Arc<Engine> {
        &self.engine
    }

    pub(super) fn step(&mut self) -> bool {
        if let Some(step) = self.next.take().or_else(|| self.past.next()) {
            if let Some(time) = self.own_time().filter(|time| *time < step.time) {
                self.next = Some(step);
                self.publish(time);
                self.engine.clock.put(time);
                self.own(time);
            } else {
                self.publish(step.time);
                self.engine.clock.put(step.clock());
                self.take(&step);
            }
            self.settle();
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
                    let words = short.then(|| value::decode(&port.value_type, old.bytes()).to_string());
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

    pub(super) fn missed(&self) -> Vec<(String, u64)> {
        let missed = self
            .histories
            .iter()
            .map(|(name, history)| (name.clone(), history.missed()));
        missed.filter(|(_, missed)| *missed > 0).collect()
    }

    pub(super) fn unknown(&self) -> Vec<String> {
        self.unknown.iter().cloned().collect()
    }

    fn find_sources(&mut self) -> Result<(), String> {
        let engine = Arc::clone(&self.engine);
        for origin in origins(&engine.application) {
            let variable = engine.variables.source(origin);
            let (writer, name) = match origin {
                Origin::Here(instance, _) => (instance as u32, engine.name(instance)),
                Origin::Elsewhere(_) => (Remote::WRITER, "elsewhere"),
            };
            let writer = variable.writer(writer, name).map_err(|error| error.to_string())?;
            let history = History::of(variable);
            self.histories
                .insert(variable.describe().full_name(), Arc::clone(&history));
            self.origins.push(origin);
            self.sources.push(Export { writer, history });
        }
        Ok(())
    }

    /// Has every input of a schema show what it showed.
    fn look_back(&mut self) {
        let (histories, watches) = (&mut self.histories, &mut self._watches);
        let mut history = |reader: &Reader| {
            let variable = reader.variable();
            let name = variable.describe().full_name();
            let history = histories.entry(name).or_insert_with(|| {
                let history = History::of(variable);
                watches.push(follow(variable, &history));
                history
            });
            Arc::clone(history)
        };
        for seat in self.seats.iter_mut().flatten() {
            seat.runner.look_back(&mut history);
        }
    }

    /// The next time at which something happens that the past does not tell of.
    fn own_time(&self) -> Option<Nanos> {
        let late = |since: Nanos| since.saturating_add(self.slack);
        let timer = self.engine.next_timer().map(late);
        let seats = self.seats.iter().flatten();
        let waiting = seats.clone().filter_map(Seat::waits_since).map(late);
        let due = seats.filter_map(|seat| seat.due);
        timer.into_iter().chain(waiting).chain(due).min()
    }

    /// What happens then.
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

    /// Carries out what the last step led to, as far as the past has no step for it.
    fn settle(&mut self) {
        let now = self.engine.clock.now();
        while let Some((number, signal)) = self.queue.pop() {
            let Some(seat) = &mut self.seats[number] else {
                continue;
            };
            match signal {
                Signal::Awake if seat.was_awake && seat.life.is_empty() => seat.live(true, now),
                Signal::Awake => seat.life.push_back((true, now)),
                Signal::Asleep if seat.was_awake && seat.told => seat.life.push_back((false, now)),
                Signal::Asleep if seat.life.is_empty() => seat.live(false, now),
                Signal::Asleep => seat.life.push_back((false, now)),
                Signal::Replaced => seat.runner.give_up_now(),
                Signal::Unloaded => seat.runner.unload_now(),
                Signal::Retimed => seat.runner.retime_now(),
                Signal::Asked { group, ticket, level } => {
                    seat.asked.retain(|asked| asked.group != group);
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
                    self.see_to_inputs(number, turn);
                }
                self.step_of(number, step);
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
                let place = seat
                    .asked
                    .iter()
                    .position(|asked| u64::from(asked.group.0) == turn.detail);
                if let Some(asked) = place.map(|place| seat.asked.swap_remove(place)) {
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
            (Turn::CYCLED, part) => {
                if seat.told {
                    seat.cycle(engine, part, &step.turn);
                }
                if part == Part::Failed {
                    // Nobody told it to sleep: it was let go.
                    seat.was_awake = false;
                }
                if step.last {
                    seat.rest();
                }
            }
            _ => {}
        }
    }

    /// A father did something with a child in its iteration.
    fn lead(&mut self, father: usize, turn: &Turn) {
        let under_way = self.seats.get(father).and_then(|seat| seat.as_ref()?.leave.clone());
        if let Some(under_way) = under_way {
            self.see_to_inputs(father, &under_way);
        }
        let Some(seat) = self.seats.get_mut(father).and_then(Option::as_mut) else {
            return;
        };
        seat.act(&self.engine);
        let awake = turn.way == Turn::WOKE;
        let mut leads = seat.leads.iter();
        let same = leads.position(|lead| (lead.child as u64, lead.awake) == (turn.detail, awake));
        if let Some(place) = same {
            self.engine.lead(seat.leads.remove(place));
        }
    }

    fn operate(&mut self, number: usize, turn: &Turn) {
        let id = SchemaId(turn.schema);
        match turn.way {
            Turn::PLAYED => self.engine.operate_again(Operator::Play(id)),
            Turn::STOPPED => self.engine.operate_again(Operator::Stop(id)),
            Turn::FORCED => self.engine.operate_again(Operator::Force(id)),
            Turn::RELEASED => self.engine.operate_again(Operator::Release(id)),
            Turn::UNLOADED => self.engine.unload_again(number),
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
                match self.past.written(&name, turn.input(0)) {
                    Some(bytes) => self.engine.put_again(&variable, &bytes),
                    None => drop(self.unknown.insert(name)),
                }
            }
            _ => {}
        }
    }

    /// Has the values be there that a turn saw of what the drivers exported.
    fn see_to_inputs(&mut self, number: usize, turn: &Turn) {
        let engine = Arc::clone(&self.engine);
        let Some(instance) = engine.application.instances.get(number) else {
            return;
        };
        for (port, binding) in instance.bindings.iter().enumerate().take(INPUTS) {
            let Binding::Import {
                source: Some(source), ..
            } = binding
            else {
                continue;
            };
            let Some(place) = self.origins.iter().position(|origin| origin == source) else {
                continue;
            };
            let wanted = turn.input(port);
            if matches!(wanted, Turn::UNSEEN | Turn::NOTHING) || has(&self.sources[place].history, wanted) {
                continue;
            }
            while let Some(old) = self.past.value_up_to(place, wanted) {
                self.give(place, &old);
            }
        }
    }

    /// Publishes what the drivers exported until then.
    fn publish(&mut self, time: Nanos) {
        for place in 0..self.sources.len() {
            while let Some(old) = self.past.value_until(place, time) {
                self.give(place, &old);
            }
        }
    }

    fn give(&mut self, place: usize, old: &Old) {
        let export = &mut self.sources[place];
        let Some(bytes) = &old.bytes else {
            export.history.retract();
            return export.writer.retract();
        };
        let room = export.writer.loan();
        if room.len() != bytes.len() {
            return;
        }
        room.copy_from_slice(bytes);
        let writer = export.writer.id();
        if export.writer.publish(old.measured, old.published).is_ok() {
            let stamp = Stamp {
                time: old.measured,
                sequence: u64::from(old.number),
                writer,
                valid_until: Nanos::MAX,
            };
            export.history.put(stamp, bytes);
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

impl Seat {
    /// One step of a period.
    fn cycle(&mut self, engine: &Engine, part: Part, turn: &Arc<Turn>) {
        if !self.runner.is_awake() {
            return;
        }
        match part {
            Part::Looked => {
                self.runner.recall(Some(turn));
                self.checked = self.runner.look_again();
                self.saw = self.runner.shown();
            }
            Part::Checked | Part::Failed => {
                if let Some(checked) = self.checked.take() {
                    self.runner.checked_again(checked);
                }
            }
            Part::Begun => {
                let leave = self.runner.begin_again(turn);
                if leave && !turn.acted.happened() {
                    // It had no leave then: there is no step of the past for this iteration.
                    let acted = self.runner.act_again();
                    self.runner.acted_again(acted);
                } else if leave {
                    self.leave = Some(Arc::clone(turn));
                }
            }
            Part::Acted => self.act(engine),
            Part::Ended => {
                self.act(engine);
                self.lead_all(engine);
                if let Some(acted) = self.acted.take() {
                    self.runner.acted_again(acted);
                }
            }
        }
    }
}

impl Seat {
    /// The iteration that it has leave for. What it asks for its children meanwhile is done when it was done first.
    fn act(&mut self, engine: &Engine) {
        if let Some(turn) = self.leave.take() {
            self.runner.recall(Some(&turn));
            engine.put_off();
            self.acted = Some(self.runner.act_again());
            self.leads = engine.taken_on();
        }
    }

    /// Does what it asked for and the past has no step for.
    fn lead_all(&mut self, engine: &Engine) {
        for lead in std::mem::take(&mut self.leads) {
            engine.lead(lead);
        }
    }
}

/// Has a history take over every value of a variable.
fn follow(variable: &Arc<Variable>, history: &Arc<History>) -> Watch {
    let history = Arc::clone(history);
    // A variable that is kept by its own watch would never go.
    let weak: Weak<Variable> = Arc::downgrade(variable);
    variable.watch(move || {
        if let Some(variable) = weak.upgrade() {
            history.take(&variable);
        }
    })
}
