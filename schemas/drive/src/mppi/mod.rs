//! Model predictive path integral control: Williams et al., "Information theoretic MPC for model-based
//! reinforcement learning", ICRA 2017. It follows a path, and leaves it for what stands on it as far as its
//! horizon shows a way around.

mod panel;
mod surroundings;

use jde_mppi::{Base, Controller, Disc, Guide, Motion, Shape, Situation, Spread, Weights};
use jde_schema::prelude::*;
use jde_schema::types::{Footprint, normalize_angle};

use crate::body::{Ability, Body, HOLD, Permit};
use crate::track::Track;
use surroundings::Surroundings;

/// The number of places along the path within the horizon.
const PLACES: u32 = 40;
/// How far places beyond the horizon count, m: the critics measure to the nearest one.
const BEYOND: f64 = 0.3;
/// Turn rate for a heading error of 1 rad while it turns on the spot, 1/s.
const GAIN: f64 = 2.0;

/// Follows a path by the mean of many sampled trajectories, around what stands on it.
///
/// For differential and omnidirectional bases and cars: `sideways` and `turning_radius` say which. It is ready
/// while it has a path, a pose, and a scan that measures something. The path is in the frame of the odometry:
/// the import if it is bound, or else the route of the file. It brakes when it could not stop in time
/// otherwise, and states the reason in the note of its mission. Samples are drawn from the application's seed.
#[derive(Describe)]
#[schema(motor, period = "50ms", budget = "20ms")]
pub struct Mppi {
    /// The scan of the laser.
    #[import(trigger)]
    laser: Import<LaserScan>,
    /// The estimated pose and velocity of the robot.
    #[import]
    pose: Import<Odometry>,
    /// The path.
    #[import(optional)]
    path: Import<jde_schema::types::Path>,
    /// The path if the import is not bound.
    #[modulation(default = Route::EMPTY)]
    route: Modulation<Route>,
    /// Distance to the end of the path below which it is reached.
    #[modulation(default = 0.15, unit = "m", min = 0.01)]
    tolerance: Modulation<f64>,
    /// Error of the last heading below which it is reached. The default accepts any heading.
    #[modulation(default = core::f64::consts::PI, unit = "rad", min = 0.01)]
    heading_tolerance: Modulation<f64>,
    /// How many trajectories are sampled.
    #[modulation(default = 2000, min = 8, max = 20_000, fixed)]
    samples: Modulation<u32>,
    /// How many steps each has.
    #[modulation(default = 56, min = 4, max = 200, fixed)]
    steps: Modulation<u32>,
    /// Duration of a step.
    #[modulation(default = 0.05, unit = "s", min = 0.01, max = 0.2, fixed)]
    step: Modulation<f64>,
    /// Standard deviation of the sampled commands, as a share of the greatest ones.
    #[modulation(default = 0.6, min = 0.01, max = 2.0)]
    spread: Modulation<f64>,
    /// Difference of costs at which a trajectory counts 1/e of another.
    #[modulation(default = 0.1, min = 0.001)]
    temperature: Modulation<f64>,
    /// Cost of a metre of distance to the path.
    #[modulation(default = 2.0, min = 0.0)]
    path_weight: Modulation<f64>,
    /// Cost of each metre by which it stays behind a drive along the path at full speed.
    #[modulation(default = 15.0, min = 0.0)]
    progress_weight: Modulation<f64>,
    /// Cost of an error of the heading of 1 rad, where the heading counts: at the end, and if the path is not
    /// ahead.
    #[modulation(default = 3.0, min = 0.0)]
    heading_weight: Modulation<f64>,
    /// Cost of a trajectory along obstacles that it nearly touches; half of `near` away costs a quarter.
    #[modulation(default = 4.0, min = 0.0)]
    obstacle_weight: Modulation<f64>,
    /// Cost of each m/s backward or to a side.
    #[modulation(default = 5.0, min = 0.0)]
    forward_weight: Modulation<f64>,
    /// Cost of a turn rate of 1 rad/s; it grows with the square.
    #[modulation(default = 0.3, min = 0.0)]
    effort_weight: Modulation<f64>,
    /// The outline of the robot.
    #[modulation(default = Footprint::circle(0.25), fixed)]
    footprint: Modulation<Footprint>,
    /// Where the laser is on the base.
    #[modulation(default = Pose2D::ORIGIN, fixed)]
    mount: Modulation<Pose2D>,
    /// Distance to keep from obstacles.
    #[modulation(default = 0.05, unit = "m", min = 0.0)]
    margin: Modulation<f64>,
    /// Clearance below which a trajectory costs more.
    #[modulation(default = 0.4, unit = "m", min = 0.0)]
    near: Modulation<f64>,
    /// How far obstacles count.
    #[modulation(default = 2.5, unit = "m", min = 0.5, max = 5.0, fixed)]
    reach: Modulation<f64>,
    /// How long an obstacle counts that is out of sight.
    #[modulation(default = 10.0, unit = "s", min = 0.0)]
    memory: Modulation<f64>,
    /// Greatest speed.
    #[modulation(default = 0.4, unit = "m/s", min = 0.0)]
    fast: Modulation<f64>,
    /// Greatest speed backward. Behind a laser that looks ahead, it knows only what it saw before.
    #[modulation(default = 0.0, unit = "m/s", min = 0.0)]
    reverse: Modulation<f64>,
    /// Greatest speed to each side, of an omnidirectional base.
    #[modulation(default = 0.0, unit = "m/s", min = 0.0)]
    sideways: Modulation<f64>,
    /// Greatest turn rate.
    #[modulation(default = 50_f64.to_radians(), unit = "rad/s", min = 0.01)]
    turn: Modulation<f64>,
    /// Least turning radius, of a car; 0 for a base that turns on the spot.
    #[modulation(default = 0.0, unit = "m", min = 0.0)]
    turning_radius: Modulation<f64>,
    /// Greatest change of speed of the base.
    #[modulation(default = 0.3, unit = "m/s2", min = 0.01)]
    acceleration: Modulation<f64>,
    /// Greatest change of turn rate of the base.
    #[modulation(default = 1.0, unit = "rad/s2", min = 0.01)]
    turn_acceleration: Modulation<f64>,
    /// Done at the end of the path. The distance is the way to it; the note states why the robot stands.
    #[export(lasting)]
    mission: Export<Mission>,
    /// Speeds of the base.
    #[actuator]
    base: Actuator<Twist>,
    body: Option<Body>,
    discs: Vec<Disc>,
    surroundings: Option<Surroundings>,
    controller: Option<Controller>,
    guide: Guide,
    track: Track,
    course: Course,
    /// When it gave the last command.
    commanded: Option<Duration>,
    /// From what it planned last, for the panel.
    planned: Option<(Base, Motion)>,
    permit: Option<Permit>,
}

/// What the robot does about its path.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
enum Course {
    /// There is no path, no pose or no usable scan.
    #[default]
    Missing,
    /// It follows the path, from this pose at this velocity.
    Along(Pose2D, Twist),
    /// It is at the end, and turns on the spot by this angle to the left, rad.
    Heading(f64, Pose2D, Twist),
    /// It is at the end of the path.
    Done,
}

impl Schema for Mppi {
    fn awake(&mut self, cx: &Context) -> Result {
        let body = Body::new(&self.footprint.get(cx), self.mount.get(cx))?;
        let discs = body.outline().discs();
        self.discs = discs
            .map(|(middle, radius)| Disc {
                x: middle.x as f32,
                y: middle.y as f32,
                radius: radius as f32,
            })
            .collect();
        self.body = Some(body);
        self.surroundings = Some(Surroundings::new(self.reach.get(cx))?);
        let shape = Shape {
            samples: self.samples.get(cx) as usize,
            steps: self.steps.get(cx) as usize,
            step: self.step.get(cx) as f32,
        };
        self.controller = Some(Controller::new(shape, cx.seed()));
        self.guide = Guide::new();
        self.track = Track::default();
        self.commanded = None;
        self.planned = None;
        Ok(())
    }

    fn check(&mut self, cx: &Context) -> Result<Precondition> {
        Ok((self.course(cx) != Course::Missing).into())
    }

    fn iterate(&mut self, cx: &Context) -> Result {
        self.course = self.course(cx);
        self.permit = match self.course {
            Course::Along(pose, velocity) => self.drive(cx, &pose, &velocity, None),
            Course::Heading(error, pose, velocity) => self.drive(cx, &pose, &velocity, Some(error)),
            Course::Missing | Course::Done => None,
        };
        let twist = match self.permit {
            Some(Permit::Go(twist)) => twist,
            // A car cannot turn on the spot.
            Some(Permit::Turn(twist, _)) if self.turning_radius.get(cx) == 0.0 => twist,
            Some(Permit::Turn(..) | Permit::Stay(_) | Permit::Unknown) | None => Twist::ZERO,
        };
        if twist == Twist::ZERO
            && let Some(controller) = &mut self.controller
        {
            controller.stand();
        }
        self.base.command(cx, twist);
        self.commanded = Some(cx.now());
        let note = self.reason().unwrap_or_default();
        self.mission
            .write(cx, self.track.mission(self.course == Course::Done, &note));
        Ok(())
    }
}

/// Refuses a footprint that is no convex area.
impl Inspect for Mppi {
    fn inspect(&self, cx: &Context, problems: &mut Problems) {
        problems.expect(
            &self.footprint,
            Body::new(&self.footprint.get(cx), self.mount.get(cx)),
        );
    }
}

impl Mppi {
    fn course(&mut self, cx: &Context) -> Course {
        let (laser, odometry) = (self.laser.get(cx), self.pose.get(cx));
        let (Some(body), Some(surroundings)) = (&mut self.body, &mut self.surroundings) else {
            return Course::Missing;
        };
        let has_track = self.track.follow(cx, &self.path, &self.route);
        let observed = body.observe(laser.as_deref(), odometry.as_deref());
        let (Some((pose, velocity)), Some(laser)) = (observed, laser) else {
            return Course::Missing;
        };
        let sensor = pose.transform(&self.mount.get(cx));
        let seen = surroundings.observe(&pose, &sensor, (&laser, laser.sequence()), cx.now());
        if seen.is_err() || !has_track {
            return Course::Missing;
        }
        self.track.advance(&pose);
        let goal = self.track.goal();
        let error = normalize_angle(goal.theta - pose.theta);
        let is_there = pose.distance_to(&goal) <= self.tolerance.get(cx)
            && self.track.left() <= 2.0 * self.tolerance.get(cx);
        if !is_there {
            Course::Along(pose, velocity)
        } else if error.abs() <= self.heading_tolerance.get(cx) {
            Course::Done
        } else if self.turning_radius.get(cx) > 0.0 {
            Course::Along(pose, velocity)
        } else {
            Course::Heading(error, pose, velocity)
        }
    }

    /// The command for the next period, checked: a turn on the spot by `spot`, or what the samples say.
    fn drive(&mut self, cx: &Context, pose: &Pose2D, velocity: &Twist, spot: Option<f64>) -> Option<Permit> {
        let age = Duration::try_from_secs_f64(self.memory.get(cx)).unwrap_or(Duration::MAX);
        let seen = self.body.as_ref()?.points();
        self.surroundings.as_mut()?.look(pose, seen, cx.now(), age);
        let wanted = match spot {
            Some(angle) => {
                let most = self.turn.get(cx);
                Twist::planar(0.0, (GAIN * angle).clamp(-most, most))
            }
            None => self.plan(cx, pose, velocity)?,
        };
        let ability = Ability {
            acceleration: self.acceleration.get(cx),
            turn_acceleration: self.turn_acceleration.get(cx),
            margin: self.margin.get(cx),
            hold: HOLD,
        };
        let points = self.surroundings.as_ref()?.points();
        Some(
            self.body
                .as_ref()?
                .permit_among(points, velocity, wanted, &ability),
        )
    }

    /// The mean of the samples.
    fn plan(&mut self, cx: &Context, pose: &Pose2D, velocity: &Twist) -> Option<Twist> {
        let (base, weights) = (self.ability(cx), self.weights(cx));
        let spread = self.spread.get(cx) as f32;
        let spread = Spread {
            deviation: [base.fast.max(base.reverse), base.sideways, base.turn].map(|most| spread * most),
            temperature: self.temperature.get(cx) as f32,
        };
        let surroundings = self.surroundings.as_ref()?;
        let start = Motion {
            pose: surroundings.to_window(pose),
            velocity: [velocity.linear.x, velocity.linear.y, velocity.angular.z].map(|part| part as f32),
        };
        let horizon = self.fast.get(cx) * self.step.get(cx) * f64::from(self.steps.get(cx));
        let (track, last) = (&self.track, self.track.length());
        let passed = last - track.left();
        let ways = (0..PLACES).map(|at| passed + (horizon + BEYOND) * f64::from(at) / f64::from(PLACES));
        let ways = ways.take_while(|way| *way < last).chain([last]);
        let places = ways.take(PLACES as usize).map(|way| {
            let [x, y, _] = surroundings.to_window(&track.at(way));
            (x, y)
        });
        self.guide.follow(start.pose, places);
        if pose.distance_to(&track.goal()) < 2.0 * self.tolerance.get(cx)
            && self.heading_tolerance.get(cx) < core::f64::consts::PI
        {
            self.guide.heading = Some(track.goal().theta as f32);
        }
        let situation = Situation {
            start,
            base,
            discs: &self.discs,
            clearance: surroundings.clearance(),
            guide: &self.guide,
            margin: self.margin.get(cx) as f32,
            near: self.near.get(cx) as f32,
            weights,
        };
        let now = cx.now();
        let elapsed = self
            .commanded
            .map_or(Duration::ZERO, |last| now.saturating_sub(last));
        let controller = self.controller.as_mut()?;
        let command = controller.command(&situation, &spread, elapsed.as_secs_f32());
        let [ahead, left, turn] = command.map(f64::from);
        self.planned = Some((base, start));
        let mut wanted = Twist::planar(ahead, turn);
        wanted.linear.y = left;
        Some(wanted)
    }

    fn ability(&self, cx: &Context) -> Base {
        Base {
            fast: self.fast.get(cx) as f32,
            reverse: self.reverse.get(cx) as f32,
            sideways: self.sideways.get(cx) as f32,
            turn: self.turn.get(cx) as f32,
            turning_radius: self.turning_radius.get(cx) as f32,
            acceleration: self.acceleration.get(cx) as f32,
            turn_acceleration: self.turn_acceleration.get(cx) as f32,
        }
    }

    fn weights(&self, cx: &Context) -> Weights {
        Weights {
            path: self.path_weight.get(cx) as f32,
            progress: self.progress_weight.get(cx) as f32,
            heading: self.heading_weight.get(cx) as f32,
            obstacle: self.obstacle_weight.get(cx) as f32,
            forward: self.forward_weight.get(cx) as f32,
            effort: self.effort_weight.get(cx) as f32,
        }
    }

    /// Why the robot does not go on; `None` if it does.
    fn reason(&self) -> Option<String> {
        match self.course {
            Course::Missing => Some("no path, no pose or no usable scan".into()),
            Course::Done => Some("at the end of the path".into()),
            Course::Along(..) | Course::Heading(..) => self.permit?.obstacle(),
        }
    }
}

#[cfg(test)]
mod tests;
