//! The world: its time and its things. What is done to its robots is in `robots`, what can be measured in `senses`.
//!
//! Time is counted in whole steps, so that a history does not depend on who advances the world, or how often.

mod firm;
mod pictures;
mod robots;
mod senses;

use std::mem;
use std::path::Path;

use parry2d_f64::math::Vector;

pub use self::robots::RobotId;

use crate::camera::Light;
use crate::error::{Fault, WorldError};
use crate::file::{self, Plan, Start};
use crate::geometry::{Bounds, Pose2};
use crate::loose::{self, Loose, Pusher};
use crate::mover::{Disc, Mover};
use crate::random::{Noise, Purpose};
use crate::robot::Robot;
use crate::scene::Scene;
use crate::shape::Shape;

/// The length of a step in nanoseconds: short beside the periods of schemas, long enough to run a day in seconds.
pub const STEP_NS: u64 = 10_000_000;

/// A world with its robots; made by [`World::load`] or [`World::parse`].
pub struct World {
    name: String,
    seed: u64,
    steps: u64,
    scene: Scene,
    movers: Vec<Mover>,
    loose: Loose,
    light: Light,
    berths: Vec<Berth>,
    bounds: Bounds,
    warnings: Vec<Fault>,
}

/// A start of the world file, and the robot that took it.
struct Berth {
    start: Start,
    robot: Option<Robot>,
}

impl World {
    /// Reads a world file, and the map it names; `seed` decides all noise.
    ///
    /// Errors: all the faults of the files together, each with its file and line.
    pub fn load(path: impl AsRef<Path>, seed: u64) -> Result<Self, WorldError> {
        let path = path.as_ref();
        let text = file::text_of(path).map_err(|error| {
            WorldError::Faults(vec![Fault {
                file: path.to_owned(),
                line: None,
                message: format!("cannot read the world: {error}"),
            }])
        })?;
        Self::parse(&text, path, seed)
    }

    /// Makes a world from the text of a file; `path` names it in errors, and a map is looked for beside it.
    ///
    /// Errors: all the faults of the text and the map together, each with its file and line.
    pub fn parse(text: &str, path: impl AsRef<Path>, seed: u64) -> Result<Self, WorldError> {
        let Plan {
            name,
            scene,
            movers,
            loose,
            light,
            starts,
            bounds,
            warnings,
        } = file::read(text, path.as_ref()).map_err(WorldError::Faults)?;
        Ok(Self {
            name,
            seed,
            steps: 0,
            scene,
            movers,
            loose: Loose::new(loose),
            light,
            berths: starts
                .into_iter()
                .map(|start| Berth { start, robot: None })
                .collect(),
            bounds,
            warnings,
        })
    }

    /// Gives the name in the file, or the file's own name.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Gives what is legal in the files but doubtful: a world without walls, a mover whose way crosses a thing.
    pub fn warnings(&self) -> &[Fault] {
        &self.warnings
    }

    /// Gives the rectangle that holds the world: the one its file states, or the one around all it names.
    pub fn bounds(&self) -> Bounds {
        self.bounds
    }

    /// Gives everything that stands or moves, as it is now, but for the robots.
    pub fn shapes(&self) -> impl Iterator<Item = Shape<'_>> {
        let loose = self.loose.bodies().iter().map(loose::Body::shape);
        self.scene
            .shapes()
            .chain(self.movers.iter().map(Mover::shape))
            .chain(loose)
    }

    /// Gives the present time in nanoseconds: a whole number of steps, at most one behind what the world was advanced to.
    pub fn now(&self) -> u64 {
        self.steps * STEP_NS
    }

    /// Moves everything on to a time in nanoseconds; a time that is past changes nothing.
    ///
    /// The cost is one step for each [`STEP_NS`] of the way.
    pub fn advance_to(&mut self, time_ns: u64) {
        while self.steps < time_ns / STEP_NS {
            self.step();
        }
    }

    fn step(&mut self) {
        let dt = STEP_NS as f64 * 1e-9;
        let discs: Vec<Disc> = self.others(usize::MAX).map(|(_, disc)| disc).collect();
        for mover in &mut self.movers {
            mover.step(dt, &discs, &self.loose);
        }
        let mut loose = mem::take(&mut self.loose);
        loose.roll(dt, &self.firm());
        self.steps += 1;
        for index in 0..self.berths.len() {
            // Taken out for its step, so that the rest of the world can be asked for its clearance.
            let Some(mut robot) = self.berths[index].robot.take() else {
                continue;
            };
            let slip = Noise::new(self.seed, index, Purpose::Slip, 0, self.steps);
            let (radius, strength) = (robot.config.radius, robot.config.max_push);
            let (pusher, firm) = (Pusher { radius, strength }, self.firm());
            robot.step(
                dt,
                &slip,
                |pose| self.clearance(index, pose, radius).1,
                |pose, dt| loose.make_room(pusher, Vector::new(pose.x, pose.y), dt, &firm),
            );
            self.berths[index].robot = Some(robot);
        }
        self.loose = loose;
        self.feel();
    }

    /// Has every robot note the gap around it, once all stand where they stand.
    fn feel(&mut self) {
        for index in 0..self.berths.len() {
            let Some(robot) = &self.berths[index].robot else {
                continue;
            };
            let (_, clearance) = self.clearance(index, robot.truth.pose, robot.config.radius);
            if let Some(robot) = &mut self.berths[index].robot {
                robot.feel(clearance);
            }
        }
    }

    /// What is nearest to a round body of all that stands, moves or lies about, and the gap; negative when they overlap.
    fn vacancy(&self, robot: usize, pose: Pose2, radius: f64) -> (&str, f64) {
        let center = Vector::new(pose.x, pose.y);
        let loose = self.loose.bodies().iter().map(|body| {
            let gap = body.solid().distance_to_point(center) - radius;
            (body.name.as_str(), gap)
        });
        loose.fold(
            self.clearance(robot, pose, radius),
            |a, b| {
                if b.1 < a.1 { b } else { a }
            },
        )
    }

    /// What is nearest to a round body but for what is loose, and the gap; negative when they overlap.
    fn clearance(&self, robot: usize, pose: Pose2, radius: f64) -> (&str, f64) {
        let center = Vector::new(pose.x, pose.y);
        let fixed = self.scene.nearest(center);
        let movers = self
            .movers
            .iter()
            .map(|mover| (mover.shape().name, mover.solid().distance_to_point(center)));
        let robots = self.others(robot).map(|(index, disc)| {
            let gap = center.distance(Vector::from(disc.center)) - disc.radius;
            (self.berths[index].start.robot.as_str(), gap)
        });
        let nearest = fixed
            .into_iter()
            .chain(movers)
            .chain(robots)
            .reduce(|a, b| if b.1 < a.1 { b } else { a });
        nearest.map_or(("nothing", f64::INFINITY), |(name, distance)| {
            (name, distance - radius)
        })
    }

    fn others(&self, except: usize) -> impl Iterator<Item = (usize, Disc)> {
        self.berths
            .iter()
            .enumerate()
            .filter(move |(index, _)| *index != except)
            .filter_map(|(index, berth)| {
                let robot = berth.robot.as_ref()?;
                let center = [robot.truth.pose.x, robot.truth.pose.y];
                Some((
                    index,
                    Disc {
                        center,
                        radius: robot.config.radius,
                    },
                ))
            })
    }
}
