//! The father of a guide: a robot that maps a building, patrols its rooms, follows who waves, leads to rooms, and docks when
//! its battery is low. It wakes a child for each task while the task is due, and says why one precedes another. It commands no
//! actuator itself.

mod charge;
mod memory;
mod panel;
mod rooms;
mod task;
mod wave;

use jde_schema::prelude::*;
use jde_schema::types::{BatteryState, ColorBlobs, Persons};

use charge::{Charge, Step};
use task::{Task, outcome};
use wave::Wave;

pub use rooms::{Room, Rooms};

/// Leads a robot through five tasks, each of which is a child: the earlier one precedes.
///
/// | task | child | due |
/// |---|---|---|
/// | dock | `approach`, then `dock` | from a charge below `low` until one of `high` |
/// | lead | `lead` | from a request for a room until the robot is there |
/// | follow | `follow` | from a wave until its mission ends, or until the next wave |
/// | map | `map` | until the map is closed |
/// | patrol | `patrol` | always |
///
/// A task is left out whose child is not bound. At the dock no other child is awake. A task that another one interrupts stays due.
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
    /// What has become of the drive to `station`: the mission of `approach`.
    #[import(optional)]
    approached: Import<Mission>,
    /// What has become of docking: the mission of `dock`.
    #[import(optional)]
    docked: Import<Mission>,
    /// What has become of leading: the mission of `lead`.
    #[import(optional)]
    led: Import<Mission>,
    /// What has become of following: the mission of `follow`.
    #[import(optional)]
    followed: Import<Mission>,
    /// What has become of the exploration.
    #[import(optional)]
    explored: Import<Mission>,
    /// The mission of `patrol`, whose `reached` counts the rooms.
    #[import(optional)]
    patrolled: Import<Mission>,
    /// The rooms, in the frame of the map, in the order of a patrol.
    #[modulation(default = Rooms { rooms: Seq::new() })]
    rooms: Modulation<Rooms>,
    /// The name of a room. Each write asks for that room; an empty one ends leading.
    #[modulation(default = "")]
    room: Modulation<Text<28>>,
    /// The places through which it comes to the dock, one after another, in the frame of the map. On the way to the last one it
    /// faces the dock.
    #[modulation(default = Route::EMPTY)]
    station: Modulation<Route>,
    /// Share of the charge below which it docks.
    #[modulation(default = 0.25, min = 0.0, max = 1.0)]
    low: Modulation<f64>,
    /// Share of the charge from which on it leaves the dock.
    #[modulation(default = 0.9, min = 0.0, max = 1.0)]
    high: Modulation<f64>,
    /// The number of the colour by which people wave, among those of the blobs.
    #[modulation(default = 0)]
    color: Modulation<u32>,
    /// How far beside the colour a person may be who waves with it.
    #[modulation(default = 0.3, unit = "rad", min = 0.0, max = 3.2)]
    beside: Modulation<f64>,
    /// How long a child may not be READY that docks or follows. Then it drives to the station anew, or follows no more.
    #[modulation(default = 10.0, unit = "s", min = 0.5, max = 3600.0)]
    patience: Modulation<f64>,
    /// How many times each task must be done until the mission is done; 0 for no end.
    #[modulation(default = 0)]
    rounds: Modulation<u32>,
    /// Where `approach` drives; none while it is not due.
    #[export]
    dock_target: Export<Target>,
    /// Where `lead` drives; none while it is not due.
    #[export]
    room_target: Export<Target>,
    /// How many tasks were done, and what it does.
    #[export]
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
    /// The route of the patrol: all rooms.
    #[modulates(child = "patrol", name = "route", optional)]
    route: Modulates<Route>,
    docking: Task,
    leading: Task,
    following: Task,
    mapping: Task,
    patrolling: Task,
    charge: Charge,
    wave: Wave,
    /// The room that is led to.
    led_to: Option<Room>,
    /// The sequence number of the last request for a room.
    asked: u64,
    /// The sequence number of the rooms that the patrol has.
    routed: Option<u64>,
}

impl Schema for Guide {
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

impl Guide {
    /// Decides when docking is due, and which of its two children acts.
    fn dock(&mut self, cx: &Context) {
        let charge = self.battery.get(cx).map(|battery| f64::from(battery.percentage));
        if let Some(charge) = charge.filter(|charge| *charge < self.low.get(cx) && !self.docking.is_due()) {
            let reason = format!("the battery is at {:.0} %", 100.0 * charge);
            self.docking.begin(cx, &reason);
            self.charge = Charge::begin(cx.now());
        }
        if !self.docking.is_due() {
            self.dock_target.write(cx, Target::NONE);
            return;
        }
        let since = self.charge.since();
        let station = self.station.get(cx);
        match self.charge.step(station.poses.len()) {
            Step::Approach(place) => {
                if let Some(outcome) = outcome(&self.approached, cx, since) {
                    if let Err(reason) = outcome {
                        warn!(cx, "does not reach place {} before the dock: {reason}", place + 1);
                    }
                    self.charge.next(cx.now());
                }
            }
            Step::Dock => {
                let is_there = matches!(outcome(&self.docked, cx, since), Some(Ok(())));
                if is_there && charge.is_some_and(|charge| charge >= self.high.get(cx)) {
                    self.docking.end(cx, true, "the battery is charged");
                } else if self.charge.is_stuck(
                    cx.now(),
                    is_there || is_ready(&self.dock, cx),
                    self.patience(cx),
                ) {
                    warn!(cx, "cannot dock: it drives to the station anew");
                    self.charge = Charge::begin(cx.now());
                }
            }
        }
        let place = match self.charge.step(station.poses.len()) {
            Step::Approach(place) if self.docking.is_due() => station.poses.get(place).copied(),
            Step::Approach(_) | Step::Dock => None,
        };
        self.dock_target.write(cx, place.map_or(Target::NONE, Target::at));
    }

    /// Takes a request for a room, and sees what has become of it.
    fn lead(&mut self, cx: &Context) {
        let asked = self.room.sample(cx);
        let sequence = asked.sequence();
        if core::mem::replace(&mut self.asked, sequence) != sequence && !asked.is_default() {
            self.ask(cx, asked.as_str(), "an operator");
        }
        if let Some(outcome) = self.leading.outcome(&self.led, cx) {
            let words = outcome.as_ref().err().map_or("is there", String::as_str);
            self.leading.end(cx, outcome.is_ok(), words);
        }
        let place = self.led_to.filter(|_| self.leading.is_due());
        let target = place.map_or(Target::NONE, |room| Target::at(room.place));
        self.room_target.write(cx, target);
    }

    /// Begins to lead to a room, or ends it for an empty name.
    fn ask(&mut self, cx: &Context, name: &str, by: &str) {
        self.leading.end(cx, false, "another room is wanted");
        if name.is_empty() {
            return;
        }
        self.led_to = self.rooms.get(cx).find(name);
        if self.led_to.is_some() {
            self.leading.begin(cx, &format!("{by} asks for `{name}`"));
        } else {
            let known = self.rooms.get(cx).names();
            warn!(cx, "no room is called `{name}`: expected one of {known}");
        }
    }

    /// Sees who waves, and what has become of following.
    fn follow(&mut self, cx: &Context) {
        if let Some(outcome) = self.following.outcome(&self.followed, cx) {
            let words = outcome.as_ref().err().map_or("arrived", String::as_str);
            self.following.end(cx, outcome.is_ok(), words);
        }
        let ready = is_ready(&self.follow, cx);
        if self.following.is_stuck(cx.now(), ready, self.patience(cx)) {
            self.following.end(cx, false, "the person is not there");
        }
        let color = self.color.get(cx);
        let blobs = self.blobs.get(cx);
        let seen = blobs
            .as_ref()
            .and_then(|blobs| blobs.blobs.iter().find(|blob| blob.color == color));
        if !self.wave.begins(cx.now(), seen.is_some()) {
            return;
        }
        let bearing = seen.map(|blob| blob.bearing);
        let (Some(bearing), Some(pose), Some(persons)) =
            (bearing, self.odometry.get(cx), self.persons.get(cx))
        else {
            return;
        };
        let person = wave::find(
            bearing,
            self.beside.get(cx),
            &pose.pose2d(),
            persons.persons.as_slice(),
        );
        match person {
            Some(_) if self.following.is_due() => self.following.end(cx, true, "the person waves again"),
            Some(id) => {
                self.person.set(cx, id);
                self.following.begin(cx, &format!("person {id} waves"));
            }
            None => return,
        }
        self.wave.take(cx.now());
    }

    fn map(&mut self, cx: &Context) {
        if self.mapping.done() == 0 && !self.mapping.is_due() && self.map.status(cx).is_some() {
            self.mapping.begin(cx, "the map is not closed");
        }
        if let Some(Ok(())) = self.mapping.outcome(&self.explored, cx) {
            self.mapping.end(cx, true, "the map is closed");
        }
    }

    fn patrol(&mut self, cx: &Context) {
        let rooms = self.rooms.sample(cx);
        if self.routed.replace(rooms.sequence()) != Some(rooms.sequence()) {
            self.route.set(cx, rooms.route());
        }
        if !self.patrolling.is_due() && self.patrol.status(cx).is_some() {
            self.patrolling.begin(cx, "nothing else is to be done");
        }
        let reached = self.patrolled.get(cx).map_or(0, |mission| mission.reached);
        if let Some(rounds) = reached.checked_div(rooms.rooms.len() as u32) {
            self.patrolling.set_done(rounds);
        }
    }

    /// Wakes the children whose tasks are due, and no others.
    fn wake(&self, cx: &Context) {
        let places = self.station.sample(cx).poses.len();
        let docks = self.docking.is_due() && self.charge.step(places) == Step::Dock;
        let due = |task: &Task| task.is_due() && !docks;
        for (child, is_due) in [
            (&self.dock, docks),
            (&self.approach, due(&self.docking)),
            (&self.lead, due(&self.leading)),
            (&self.follow, due(&self.following)),
            (&self.map, due(&self.mapping)),
            (&self.patrol, due(&self.patrolling)),
        ] {
            if is_due {
                child.wake(cx);
            } else if child.state(cx) != State::Slept {
                child.sleep(cx);
            }
        }
    }

    fn report(&mut self, cx: &Context) {
        let words = self.words();
        let rounds = self.rounds.get(cx);
        let bound: Vec<u32> = self
            .tasks()
            .into_iter()
            .filter(|(_, child, _)| child.status(cx).is_some())
            .map(|(_, _, task)| task.done())
            .collect();
        let is_done = rounds > 0 && bound.iter().all(|done| *done >= rounds);
        self.mission.write(
            cx,
            Mission {
                state: if is_done { Mission::DONE } else { Mission::RUNNING },
                reached: bound
                    .iter()
                    .map(|done| if rounds > 0 { *done.min(&rounds) } else { *done })
                    .sum(),
                total: rounds.saturating_mul(bound.len() as u32),
                note: Text::truncated(&words),
                ..Mission::default()
            },
        );
        self.state.write(cx, Text::truncated(&words));
    }

    /// The tasks in the order in which they precede, with the child that shows whether a task is bound.
    fn tasks(&self) -> [(&'static str, &Child, &Task); 5] {
        [
            ("dock", &self.dock, &self.docking),
            ("lead", &self.lead, &self.leading),
            ("follow", &self.follow, &self.following),
            ("map", &self.map, &self.mapping),
            ("patrol", &self.patrol, &self.patrolling),
        ]
    }

    /// The tasks that are due, each with its reason.
    fn words(&self) -> String {
        let due = self.tasks().into_iter();
        let due = due.filter_map(|(name, _, task)| Some(format!("{name}: {}", task.reason()?)));
        due.collect::<Vec<_>>().join("; ")
    }

    fn patience(&self, cx: &Context) -> Duration {
        Duration::from_secs_f64(self.patience.get(cx))
    }
}

fn is_ready(child: &Child, cx: &Context) -> bool {
    matches!(child.state(cx), State::Ready | State::Winner)
}

impl Arbitrate for Guide {
    fn arbitrate(&mut self, _: &Context, level: &Level) -> Result<Verdict> {
        let candidates = [
            (&self.dock, &self.docking),
            (&self.approach, &self.docking),
            (&self.lead, &self.leading),
            (&self.follow, &self.following),
            (&self.map, &self.mapping),
            (&self.patrol, &self.patrolling),
        ];
        let first = candidates.into_iter().find(|(child, _)| level.is_ready(child));
        Ok(match first {
            Some((child, task)) => Verdict::choose(child, task.reason().unwrap_or("it is due no more")),
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
