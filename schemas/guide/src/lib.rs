//! The father of a guide: a robot that maps a building, patrols its rooms, follows a person who waves, leads to rooms, and docks when
//! its battery is low. It wakes a child for each task while the task is due, and says why one precedes another. It commands no
//! actuator itself.

mod charge;
mod memory;
mod panel;
mod rooms;
mod task;
mod wait;
mod wave;

use jde_motion::OdometryHistory;
use jde_schema::prelude::*;
use jde_schema::types::{BatteryState, ColorBlob, ColorBlobs, Persons};

use charge::{Charge, Step};
use task::{Task, outcome};
use wave::Wave;

pub use rooms::{Room, Rooms};

/// Leads a robot through five tasks, each of which is a child. A task has priority over those below it:
///
/// | task | child | due |
/// |---|---|---|
/// | dock | `approach`, then `dock` | from a charge below `low` until a charge of `high` |
/// | lead | `lead` | from a request for a room until the robot is there |
/// | follow | `follow` | from a wave until its mission ends, or until that person waves again |
/// | map | `map` | until the map is closed |
/// | patrol | `patrol` | always |
///
/// A task whose child is not bound is left out. A child that is bound needs the import of its mission. At the dock no
/// other child is awake. A task that is interrupted stays due.
#[derive(Describe)]
#[schema(motor, period = "200ms", budget = "20ms")]
pub struct Guide {
    /// The battery. Without a value, the robot stays at the task that it has.
    #[import(optional)]
    battery: Import<BatteryState>,
    /// Areas of colour that the camera sees, by which people wave.
    #[import(optional)]
    blobs: Import<ColorBlobs>,
    /// The persons around the robot.
    #[import(optional)]
    persons: Import<Persons>,
    /// The pose of the robot in the frame of the persons.
    #[import(optional)]
    odometry: Import<Odometry>,
    /// The outcome of the drive to `station`: the mission of `approach`.
    #[import(optional)]
    approached: Import<Mission>,
    /// The outcome of docking: the mission of `dock`.
    #[import(optional)]
    docked: Import<Mission>,
    /// The outcome of leading: the mission of `lead`.
    #[import(optional)]
    led: Import<Mission>,
    /// The outcome of following: the mission of `follow`.
    #[import(optional)]
    followed: Import<Mission>,
    /// The outcome of the exploration.
    #[import(optional)]
    explored: Import<Mission>,
    /// The mission of `patrol`, whose `reached` counts the rooms.
    #[import(optional)]
    patrolled: Import<Mission>,
    /// The rooms, in the frame of the map, in the order of a patrol.
    #[modulation(default = Rooms { rooms: Seq::new() })]
    rooms: Modulation<Rooms>,
    /// The name of a room. The name in the application's file is a request for that room, and so is each later write;
    /// an empty name ends leading.
    #[modulation(default = "")]
    room: Modulation<Text<28>>,
    /// The places through which it comes to the dock, one after another, in the frame of the map. On the way to the last one it
    /// faces the dock.
    #[modulation(default = Route::EMPTY)]
    station: Modulation<Route>,
    /// Share of the charge below which it docks; less than `high`.
    #[modulation(default = 0.25, min = 0.0, max = 1.0)]
    low: Modulation<f64>,
    /// Share of the charge at which it leaves the dock.
    #[modulation(default = 0.9, min = 0.0, max = 1.0)]
    high: Modulation<f64>,
    /// The number of the colour by which people wave, among those of the blobs.
    #[modulation(default = 0)]
    color: Modulation<u32>,
    /// How far beside the colour the waving person may be.
    #[modulation(default = 0.3, unit = "rad", min = 0.0, max = 3.2)]
    beside: Modulation<f64>,
    /// How long a child that docks or follows may be awake without being READY, and the robot at the dock without being
    /// charged. Then it drives to the station again, or stops following.
    #[modulation(default = 10.0, unit = "s", min = 0.5, max = 3600.0)]
    patience: Modulation<f64>,
    /// Number of times that each task must be done until the mission is done; 0 for no end. The patrol is done once
    /// when it has reached as many rooms as there are.
    #[modulation(default = 0)]
    rounds: Modulation<u32>,
    /// Where `approach` drives; none while it is not due.
    #[export(lasting)]
    dock_target: Export<Target>,
    /// Where `lead` drives; none while it is not due.
    #[export(lasting)]
    room_target: Export<Target>,
    /// The number of tasks that were done, and the present one.
    #[export(lasting)]
    mission: Export<Mission>,
    /// The tasks that are due, each with its reason, the first one first.
    #[export]
    state: Export<Text<160>>,
    /// Docks.
    #[child(group = "base", optional)]
    dock: Child,
    /// Drives to the station before the dock.
    #[child(group = "base", optional)]
    approach: Child,
    /// Drives to a room.
    #[child(group = "base", optional)]
    lead: Child,
    /// Follows a person.
    #[child(group = "base", optional)]
    follow: Child,
    /// Drives where the map is open.
    #[child(group = "base", optional)]
    map: Child,
    /// Drives from room to room for ever.
    #[child(group = "base", optional)]
    patrol: Child,
    /// The person to follow.
    #[modulates(child = "follow", name = "id", optional)]
    person: Modulates<u32>,
    /// The route of the patrol: all rooms. Without rooms it keeps its own.
    #[modulates(child = "patrol", name = "route", optional)]
    route: Modulates<Route>,
    docking: Task,
    leading: Task,
    following: Task,
    mapping: Task,
    patrolling: Task,
    charge: Charge,
    wave: Wave,
    /// Where the robot was when pictures were taken.
    history: OdometryHistory,
    /// Whether the time of the pictures says nothing, which the log says once.
    is_untimely: bool,
    /// The room that is led to.
    led_to: Option<Room>,
    /// The sequence number of the last request for a room; `None` before the first iteration.
    asked: Option<u64>,
    /// The sequence number of the rooms that the patrol has.
    routed: Option<u64>,
}

impl Schema for Guide {
    fn awake(&mut self, cx: &Context) -> Result {
        for (role, child, name, mission) in [
            ("dock", &self.dock, "docked", &self.docked),
            ("approach", &self.approach, "approached", &self.approached),
            ("lead", &self.lead, "led", &self.led),
            ("follow", &self.follow, "followed", &self.followed),
            ("map", &self.map, "explored", &self.explored),
            ("patrol", &self.patrol, "patrolled", &self.patrolled),
        ] {
            if is_bound(child, cx) && !mission.is_bound(cx) {
                let error =
                    format!("the child `{role}` has no mission here: bind `{name}`, or leave the child out");
                return Err(error.into());
            }
        }
        let room = self.room.sample(cx);
        if self.asked.is_none() && !room.is_default() {
            self.asked = Some(room.sequence());
        }
        self.following.wait_anew(cx.now());
        self.charge.wait_anew(cx.now());
        Ok(())
    }

    fn iterate(&mut self, cx: &Context) -> Result {
        self.dock(cx);
        self.lead(cx);
        self.follow(cx);
        self.map(cx);
        self.patrol(cx);
        self.wake(cx);
        self.report(cx);
        Ok(())
    }
}

impl Inspect for Guide {
    fn inspect(&self, cx: &Context, problems: &mut Problems) {
        let (low, high) = (self.low.get(cx), self.high.get(cx));
        if low >= high {
            problems.wrong(
                &self.high,
                format!("the robot docks below {low} and leaves at {high}: `high` must be more than `low`"),
            );
        }
        problems.expect(&self.rooms, self.rooms.sample(cx).check());
    }
}

impl Guide {
    /// Decides when docking is due, and which of its two children acts.
    fn dock(&mut self, cx: &Context) {
        let battery = self.battery.get(cx);
        let charge = battery.as_ref().map(|battery| f64::from(battery.percentage));
        let (low, high) = (self.low.get(cx), self.high.get(cx));
        if let Some(charge) = charge
            && charge < low
            && !self.docking.is_due()
            && is_bound(&self.dock, cx)
        {
            self.docking
                .begin(cx, &format!("the battery is at {:.0} %", 100.0 * charge));
            self.charge = Charge::begin(cx.now());
        }
        if !self.docking.is_due() {
            self.dock_target.write(cx, Target::NONE);
            return;
        }
        let since = self.charge.since();
        match self.step(cx) {
            Step::Approach(place) => {
                let target = self.place(cx);
                if let Some(outcome) = outcome(cx, &self.approached, since, target.as_ref()) {
                    if let Err(reason) = outcome {
                        warn!(cx, "does not reach place {} before the dock: {reason}", place + 1);
                    }
                    self.charge.next(cx.now());
                }
            }
            Step::Dock => {
                let is_there = matches!(outcome(cx, &self.docked, since, None), Some(Ok(())));
                let charges = is_there && !battery.is_some_and(|battery| is_idle(&battery));
                if is_there && charge.is_some_and(|charge| charge >= low.max(high)) {
                    self.docking.end(cx, true, "the battery is charged");
                } else if self.charge.is_stuck(cx, &self.dock, charges, self.patience(cx)) {
                    let what = if is_there {
                        "it does not charge"
                    } else {
                        "it cannot dock"
                    };
                    warn!(cx, "{what}: it comes to the dock anew");
                    self.charge = Charge::begin(cx.now());
                }
            }
        }
        let place = self.place(cx).filter(|_| self.docking.is_due());
        self.dock_target.write(cx, place.map_or(Target::NONE, Target::at));
    }

    /// Where it is on the way to the dock. Without the child that drives to the station, it is before the dock at once.
    fn step(&self, cx: &Context) -> Step {
        let places = self.station.sample(cx).poses.len();
        self.charge
            .step(if is_bound(&self.approach, cx) { places } else { 0 })
    }

    /// The place of the station to which it drives.
    fn place(&self, cx: &Context) -> Option<Pose2D> {
        match self.step(cx) {
            Step::Approach(place) => self.station.sample(cx).poses.get(place).copied(),
            Step::Dock => None,
        }
    }

    /// Takes a request for a room, and sees what has become of it.
    fn lead(&mut self, cx: &Context) {
        let room = self.room.sample(cx);
        let is_stated = self.asked.is_none() && !room.is_empty();
        if self.asked.replace(room.sequence()) != Some(room.sequence()) {
            if is_stated && room.is_default() {
                self.ask(cx, room.as_str(), "the application");
            } else if !room.is_default() {
                self.ask(cx, room.as_str(), "an operator");
            }
        }
        let place = self.led_to.map(|room| room.place);
        if let Some(outcome) = self.leading.outcome(cx, &self.led, place.as_ref()) {
            let words = outcome.as_ref().err().map_or("is there", String::as_str);
            self.leading.end(cx, outcome.is_ok(), words);
        }
        let place = place.filter(|_| self.leading.is_due());
        self.room_target.write(cx, place.map_or(Target::NONE, Target::at));
    }

    /// Begins to lead to a room, or ends it for an empty name.
    fn ask(&mut self, cx: &Context, name: &str, by: &str) {
        if name.is_empty() {
            self.leading.end(cx, false, "no room is wanted any more");
            return;
        }
        let rooms = self.rooms.sample(cx);
        let Some(room) = rooms.find(name) else {
            let known = rooms.names();
            warn!(cx, "no room is called `{name}`: expected one of {known}");
            return;
        };
        if !is_bound(&self.lead, cx) {
            warn!(cx, "it leads to no room: the application leaves `lead` out");
            return;
        }
        self.leading.end(cx, false, "another room is wanted");
        self.led_to = Some(room);
        self.leading.begin(cx, &format!("{by} asks for `{name}`"));
    }

    /// Sees who waves, and what has become of following.
    fn follow(&mut self, cx: &Context) {
        if !is_bound(&self.follow, cx) {
            return;
        }
        if let Some(outcome) = self.following.outcome(cx, &self.followed, None) {
            let words = outcome.as_ref().err().map_or("arrived", String::as_str);
            self.following.end(cx, outcome.is_ok(), words);
        }
        let patience = self.patience(cx);
        if self.following.is_stuck(cx, &self.follow, patience) {
            self.following.end(cx, false, "the person is not there");
        }
        let odometry = self.odometry.get(cx);
        if let Some(odometry) = &odometry {
            self.history.add(odometry.time(), odometry);
        }
        let color = self.color.get(cx);
        let Some(blobs) = self.blobs.get(cx) else { return };
        let is_wave = |blob: &&ColorBlob| blob.color == color;
        if !self
            .wave
            .begins(cx.now(), blobs.blobs.iter().any(|blob| is_wave(&blob)))
        {
            return;
        }
        let (Some(_), Some(persons)) = (odometry, self.persons.get(cx)) else {
            return;
        };
        let robot = match self.history.base("pictures", blobs.time(), cx.now()) {
            Ok(robot) => robot,
            Err(words) => {
                if !core::mem::replace(&mut self.is_untimely, true) {
                    warn!(cx, "cannot tell who waves: {words}");
                }
                return;
            }
        };
        self.is_untimely = false;
        let persons = persons.persons.as_slice();
        let beside = self.beside.get(cx);
        let waving = blobs.blobs.iter().filter(is_wave);
        let mut waving = waving.filter_map(|blob| wave::find(blob.bearing, beside, &robot, persons));
        if self.following.is_due() {
            // The number of the person may have changed, and the place has not.
            let target = self.followed.get(cx).filter(|_| is_ready(&self.follow, cx));
            let followed = target.and_then(|mission| wave::at(&mission.target, persons));
            if !waving.any(|id| Some(id) == followed) {
                return;
            }
            self.following.end(cx, true, "the person waves again");
        } else {
            let Some(id) = waving.next() else { return };
            self.person.set(cx, id);
            self.following.begin(cx, &format!("person {id} waves"));
        }
        self.wave.take(cx.now());
    }

    fn map(&mut self, cx: &Context) {
        if self.mapping.done() == 0 && !self.mapping.is_due() && is_bound(&self.map, cx) {
            self.mapping.begin(cx, "the map is not closed");
        }
        if let Some(Ok(())) = self.mapping.outcome(cx, &self.explored, None) {
            self.mapping.end(cx, true, "the map is closed");
        }
    }

    fn patrol(&mut self, cx: &Context) {
        let rooms = self.rooms.sample(cx);
        let is_new = self.routed.replace(rooms.sequence()) != Some(rooms.sequence());
        if is_new && !rooms.rooms.is_empty() {
            self.route.set(cx, rooms.route());
        }
        if !self.patrolling.is_due() && is_bound(&self.patrol, cx) {
            self.patrolling.begin(cx, "nothing else is to be done");
        }
        let reached = self.patrolled.get(cx).map_or(0, |mission| mission.reached);
        if let Some(rounds) = reached.checked_div(rooms.rooms.len() as u32) {
            self.patrolling.set_done(rounds);
        }
    }

    /// Wakes the children whose tasks are due, and no others.
    fn wake(&self, cx: &Context) {
        let docks = self.docking.is_due() && self.step(cx) == Step::Dock;
        for (name, child, task) in self.children() {
            if task.is_due() && (name == "dock") == docks {
                child.wake(cx);
            } else if child.state(cx) != State::Slept {
                child.sleep(cx);
            }
        }
    }

    fn report(&mut self, cx: &Context) {
        let words = self.words(cx);
        let rounds = self.rounds.get(cx);
        let has_rooms = !self.rooms.sample(cx).rooms.is_empty();
        let tasks = self.tasks(cx).filter(|(name, ..)| has_rooms || *name != "patrol");
        let done: Vec<u32> = tasks.map(|(_, _, task)| task.done()).collect();
        let is_done = rounds > 0 && !done.is_empty() && done.iter().all(|done| *done >= rounds);
        self.mission.write(
            cx,
            Mission {
                state: if is_done { Mission::DONE } else { Mission::RUNNING },
                reached: done
                    .iter()
                    .map(|done| if rounds > 0 { *done.min(&rounds) } else { *done })
                    .sum(),
                total: rounds.saturating_mul(done.len() as u32),
                note: Text::truncated(&words),
                ..Mission::default()
            },
        );
        self.state.write(cx, Text::truncated(&words));
    }

    /// The children with their tasks, in the order in which they precede.
    fn children(&self) -> [(&'static str, &Child, &Task); 6] {
        [
            ("dock", &self.dock, &self.docking),
            ("approach", &self.approach, &self.docking),
            ("lead", &self.lead, &self.leading),
            ("follow", &self.follow, &self.following),
            ("map", &self.map, &self.mapping),
            ("patrol", &self.patrol, &self.patrolling),
        ]
    }

    /// The tasks that are not left out.
    fn tasks(&self, cx: &Context) -> impl Iterator<Item = (&'static str, &Child, &Task)> {
        let children = self.children().into_iter();
        children.filter(|(name, child, _)| *name != "approach" && is_bound(child, cx))
    }

    /// The tasks that are due, each with its reason.
    fn words(&self, cx: &Context) -> String {
        let due = self
            .tasks(cx)
            .filter_map(|(name, _, task)| Some(format!("{name}: {}", task.reason()?)));
        due.collect::<Vec<_>>().join("; ")
    }

    fn patience(&self, cx: &Context) -> Duration {
        Duration::from_secs_f64(self.patience.get(cx))
    }
}

fn is_bound(child: &Child, cx: &Context) -> bool {
    child.status(cx).is_some()
}

fn is_ready(child: &Child, cx: &Context) -> bool {
    matches!(child.state(cx), State::Ready | State::Winner)
}

/// Whether a battery says that it is not charged: by its status, and without one by its current.
fn is_idle(battery: &BatteryState) -> bool {
    match battery.power_supply_status {
        // Charging, full.
        1 | 4 => false,
        // Discharging, not charging.
        2 | 3 => true,
        _ => battery.current < 0.0,
    }
}

impl Arbitrate for Guide {
    fn arbitrate(&mut self, _: &Context, level: &Level) -> Result<Verdict> {
        let first = self
            .children()
            .into_iter()
            .find(|(_, child, _)| level.is_ready(child));
        Ok(match first {
            Some((_, child, task)) => Verdict::choose(child, task.reason().unwrap_or("it is due no more")),
            None => Verdict::nobody("no child is ready"),
        })
    }
}

jde_schema::export!(
    "guide",
    "Leads a robot that maps, patrols, follows, guides and docks.",
    [Guide]
);

#[cfg(test)]
mod tests;
