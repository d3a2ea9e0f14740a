//! The world: its time and its things. `robots` changes its robots, `edits` its things, and `readings`
//! measures.
//!
//! Time advances in whole steps, so that a run does not depend on how the caller divides the time.

mod edits;
mod obstacles;
mod pictures;
mod readings;
mod robots;

use std::mem;
use std::path::Path;

use parry2d_f64::math::Vector;

pub use self::robots::RobotId;

use crate::camera::Light;
use crate::charger::Charger;
use crate::error::{Fault, WorldError};
use crate::file::{self, Start, WorldFile};
use crate::floor::Floor;
use crate::footprint::RobotBody;
use crate::geometry::Bounds;
use crate::loose::{self, LooseBodies, Pusher};
use crate::mover::Mover;
use crate::random::{Noise, Purpose};
use crate::robot::SimulatedRobot;
use crate::scene::Scene;
use crate::shape::Shape;
use crate::solid::Solid;
use crate::tag::Tag;

/// The length of a step in nanoseconds: short compared with periods of schemas, long enough to run a day in
/// seconds.
pub const STEP_NS: u64 = 10_000_000;

/// A world with its robots. [`World::load`] and [`World::parse`] create it.
pub struct World {
    name: String,
    seed: u64,
    steps: u64,
    scene: Scene,
    movers: Vec<Mover>,
    loose: LooseBodies,
    floor: Floor,
    light: Light,
    tags: Vec<Tag>,
    chargers: Vec<Charger>,
    robot_slots: Vec<RobotSlot>,
    bounds: Bounds,
    reference_length: Option<f64>,
    warnings: Vec<Fault>,
    /// How often the standing things have changed.
    changes: u64,
}

/// A start of the world file, and the robot that was added there.
struct RobotSlot {
    start: Start,
    robot: Option<SimulatedRobot>,
}

impl World {
    /// Reads a world file and the map that it names. `seed` determines all noise.
    ///
    /// # Errors
    /// All faults of the files, each with its file and line.
    pub fn load(path: impl AsRef<Path>, seed: u64) -> Result<Self, WorldError> {
        let path = path.as_ref();
        Self::parse(&file::load(path, "world")?, path, seed)
    }

    /// Creates a world from the text of a world file. `path` names it in errors; a map's path is relative to
    /// its folder.
    ///
    /// # Errors
    /// All faults of the text and the map, each with its file and line.
    pub fn parse(text: &str, path: impl AsRef<Path>, seed: u64) -> Result<Self, WorldError> {
        let WorldFile {
            name,
            scene,
            movers,
            loose,
            floor,
            light,
            tags,
            chargers,
            starts,
            bounds,
            reference_length,
            warnings,
        } = file::read(text, path.as_ref())?;
        Ok(Self {
            name,
            seed,
            steps: 0,
            scene,
            movers,
            loose: LooseBodies::new(loose),
            floor,
            light,
            tags,
            chargers,
            robot_slots: starts
                .into_iter()
                .map(|start| RobotSlot { start, robot: None })
                .collect(),
            bounds,
            reference_length,
            warnings,
            changes: 0,
        })
    }

    /// Returns the name in the file, or the stem of the file's name.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Returns the length of the reference path that the file states, in metres.
    pub fn reference_length(&self) -> Option<f64> {
        self.reference_length
    }

    /// Returns what is legal in the files but doubtful: a world without walls, a mover whose way crosses a
    /// thing.
    pub fn warnings(&self) -> &[Fault] {
        &self.warnings
    }

    /// Returns the bounds of the world: those that its file states, or else the box around all that the file
    /// names.
    pub fn bounds(&self) -> Bounds {
        self.bounds
    }

    /// Returns all things as they are now, except the robots.
    pub fn shapes(&self) -> impl Iterator<Item = Shape<'_>> {
        let loose = self.loose.bodies().iter().map(loose::LooseBody::shape);
        self.scene
            .shapes()
            .chain(self.movers.iter().map(Mover::shape))
            .chain(loose)
    }

    /// Returns what is painted on the floor, the later over the earlier: one rectangle for each leg of a line,
    /// for each area, and for each tile of its second colour. A millimetre of height for each layer tells
    /// which covers the other.
    pub fn paint(&self) -> impl Iterator<Item = Shape<'_>> {
        self.floor.shapes()
    }

    /// Returns the present time in nanoseconds: a multiple of [`STEP_NS`], less than one step behind the time
    /// that the world was advanced to.
    pub fn now(&self) -> u64 {
        self.steps * STEP_NS
    }

    /// Steps the world up to a time in nanoseconds. A time in the past changes nothing.
    ///
    /// It takes one step for each [`STEP_NS`].
    pub fn advance_to(&mut self, time_ns: u64) {
        while self.steps < time_ns / STEP_NS {
            self.step();
        }
    }

    fn step(&mut self) {
        let dt = STEP_NS as f64 * 1e-9;
        let robots: Vec<Solid> = self.others(usize::MAX).map(|(_, body)| body.solid()).collect();
        for mover in &mut self.movers {
            mover.step(dt, &robots, &self.loose);
        }
        let mut loose = mem::take(&mut self.loose);
        loose.roll(dt, &self.obstacles());
        self.steps += 1;
        for index in 0..self.robot_slots.len() {
            // The robot is taken out for its step, so that its closures can borrow the rest of the world.
            let Some(mut robot) = self.robot_slots[index].robot.take() else {
                continue;
            };
            let slip = Noise::new(self.seed, index, Purpose::Slip, 0, self.steps);
            let footprint = robot.config.footprint.clone();
            let (radius, strength) = (footprint.radius(), robot.config.max_push);
            let (pusher, firm) = (Pusher { radius, strength }, self.obstacles());
            let mut chargers = self.chargers.iter();
            let charger = chargers.find(|charger| charger.holds(robot.truth.pose));
            robot.supply(charger.map_or(0.0, |charger| charger.current));
            robot.step(
                dt,
                &slip,
                |pose| self.clearance(index, &footprint.at(pose)).1,
                |pose, dt| loose.push_away(pusher, Vector::new(pose.x, pose.y), dt, &firm),
            );
            self.robot_slots[index].robot = Some(robot);
        }
        self.loose = loose;
        self.update_contacts();
    }

    /// Updates every robot's clearance, after all have moved.
    fn update_contacts(&mut self) {
        for index in 0..self.robot_slots.len() {
            let Some(robot) = &self.robot_slots[index].robot else {
                continue;
            };
            let (_, clearance) = self.clearance(index, &robot.body());
            if let Some(robot) = &mut self.robot_slots[index].robot {
                robot.update_contact(clearance);
            }
        }
    }

    /// Returns the nearest thing to a body, loose things included, and the gap. The gap is negative on
    /// overlap.
    fn placement_clearance(&self, robot: usize, body: &RobotBody) -> (&str, f64) {
        let loose = self.loose.bodies().iter().map(|thing| {
            let gap = thing.solid().distance_to_point(body.center()) - body.radius();
            (thing.name.as_str(), gap)
        });
        loose.fold(self.clearance(robot, body), |a, b| if b.1 < a.1 { b } else { a })
    }

    /// Returns the nearest thing to a body, loose things excluded, and the gap. The gap is negative on
    /// overlap.
    fn clearance(&self, robot: usize, body: &RobotBody) -> (&str, f64) {
        let movers = self
            .movers
            .iter()
            .map(|mover| (mover.name(), body.gap_to(mover.solid())));
        let robots = self.others(robot).map(|(index, other)| {
            (
                self.robot_slots[index].start.robot.as_str(),
                body.gap_to_body(&other),
            )
        });
        let things = self.scene.nearest_to(body).into_iter().chain(movers);
        things
            .chain(robots)
            .reduce(|a, b| if b.1 < a.1 { b } else { a })
            .unwrap_or(("nothing", f64::INFINITY))
    }

    fn others(&self, except: usize) -> impl Iterator<Item = (usize, RobotBody)> {
        self.robot_slots
            .iter()
            .enumerate()
            .filter(move |(index, _)| *index != except)
            .filter_map(|(index, slot)| Some((index, slot.robot.as_ref()?.body())))
    }
}
