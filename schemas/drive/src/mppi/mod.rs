//! Model predictive path integral control: Williams et al., "Information theoretic MPC for model-based
//! reinforcement learning", ICRA 2017. It follows a path, and leaves it for what stands on it as far as its
//! horizon shows a way around.

mod panel;
mod ports;
mod surroundings;

use jde_mppi::{Base, Command, Controller, Disc, Guide, Motion, Situation, Spread};
use jde_schema::prelude::*;

use crate::body::{Body, HOLD, Permit};
use crate::ports::{PathGoal, PathToFollow, Perception, RobotBase, VelocityLimits};
use crate::track::Track;
use ports::{Critics, Kinematics, Obstacles, Sampling};
use surroundings::Surroundings;

/// The number of places along the path within the horizon.
const PLACES: u32 = 40;
/// How far places beyond the horizon count, m: the critics measure to the nearest one.
const MAX_BEYOND: f64 = 0.3;

/// Follows a path by the mean of many sampled trajectories, and goes around obstacles on it.
///
/// The base is differential, omnidirectional or a car: `vy_max` and `min_turning_r` state which. The schema is ready
/// while it has a path, a pose, and a scan with a measurement. The path is in the frame of the odometry: the import
/// if it is bound, or else the route of the file. It brakes when it could not stop in time otherwise, and states the
/// reason in the note of its mission. Samples are drawn from the application's seed.
#[derive(Describe)]
#[schema(motor, period = "50ms", budget = "20ms")]
pub struct Mppi {
    #[ports]
    perception: Perception,
    #[ports]
    path: PathToFollow,
    #[ports]
    goal: PathGoal,
    #[ports]
    sampling: Sampling,
    #[ports]
    critics: Critics,
    #[ports]
    robot: RobotBase,
    #[ports]
    obstacles: Obstacles,
    #[ports]
    limits: VelocityLimits,
    #[ports]
    kinematics: Kinematics,
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
    /// There is no path, no pose, no usable scan or no dynamics of the base.
    #[default]
    Missing,
    /// It follows the path, from this pose.
    Along(Pose2D),
    /// It is at the end, and turns on the spot by this angle to the left, rad.
    Heading(f64, Pose2D),
    /// It is at the end of the path.
    Done,
}

impl Schema for Mppi {
    fn awake(&mut self, cx: &Context) -> Result {
        let body = self.robot.body(cx)?;
        let discs = body.outline().discs();
        self.discs = discs
            .map(|(middle, radius)| Disc {
                x: middle.x as f32,
                y: middle.y as f32,
                radius: radius as f32,
            })
            .collect();
        self.body = Some(body);
        self.surroundings = Some(Surroundings::new(self.obstacles.reach.get(cx))?);
        let shape = self.sampling.shape(cx);
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
            Course::Along(pose) => self.drive(cx, &pose, None),
            Course::Heading(error, pose) => self.drive(cx, &pose, Some(error)),
            Course::Missing | Course::Done => None,
        };
        let twist = match self.permit {
            Some(Permit::Go(twist)) => twist,
            // A car cannot turn on the spot.
            Some(Permit::Turn(twist, _)) if self.kinematics.min_turning_r.get(cx) == 0.0 => twist,
            Some(Permit::Turn(..) | Permit::Stay(_) | Permit::Unknown) | None => Twist::ZERO,
        };
        if twist == Twist::ZERO
            && let Some(controller) = &mut self.controller
        {
            controller.stand();
        }
        self.robot.base.command(cx, twist);
        self.commanded = Some(cx.now());
        let note = self.reason().unwrap_or_default();
        self.goal
            .mission
            .write(cx, self.track.mission(self.course == Course::Done, &note));
        Ok(())
    }
}

/// Refuses a footprint that is no convex area.
impl Inspect for Mppi {
    fn inspect(&self, cx: &Context, problems: &mut Problems) {
        self.robot.inspect(cx, problems);
    }
}

impl Mppi {
    fn course(&mut self, cx: &Context) -> Course {
        let (laser, odometry) = (self.perception.laser.get(cx), self.perception.pose.get(cx));
        let (Some(body), Some(surroundings)) = (&mut self.body, &mut self.surroundings) else {
            return Course::Missing;
        };
        let has_track = self.track.follow(cx, &self.path.path, &self.path.route);
        let observed = body.observe(cx, laser.as_ref(), odometry.as_ref(), self.robot.motors(cx));
        let (Some((pose, _)), Some(laser), Some(sweep)) = (observed, laser, body.sweep()) else {
            return Course::Missing;
        };
        let seen = surroundings.observe(&pose, body.jumps(), &laser, sweep, &self.robot.mount.get(cx));
        if seen.is_err() || !has_track {
            return Course::Missing;
        }
        self.track.advance(&pose);
        let goal = self.track.goal();
        let is_there = pose.distance_to(&goal) <= self.goal.xy_goal_tolerance.get(cx)
            && self.track.left() <= 2.0 * self.goal.xy_goal_tolerance.get(cx);
        match self.goal.turn(cx, pose.theta, &goal) {
            _ if !is_there => Course::Along(pose),
            Some(error) if self.kinematics.min_turning_r.get(cx) == 0.0 => Course::Heading(error, pose),
            // A car is at its end with any heading: it would turn about the place for ever.
            Some(_) | None => Course::Done,
        }
    }

    /// The command for the next period, checked: a turn on the spot by `spot`, or what the samples say.
    fn drive(&mut self, cx: &Context, pose: &Pose2D, spot: Option<f64>) -> Option<Permit> {
        let age = Duration::try_from_secs_f64(self.obstacles.observation_persistence.get(cx))
            .unwrap_or(Duration::MAX);
        let seen = self.body.as_ref()?.points();
        self.surroundings.as_mut()?.look(pose, seen, cx.now(), age);
        let wanted = match spot {
            Some(angle) => (self.limits).spot(cx, angle, self.goal.min_in_place_vel_theta.get(cx)),
            None => self.plan(cx, pose)?,
        };
        let ability = self.robot.ability(cx, self.obstacles.margin.get(cx), HOLD);
        let points = self.surroundings.as_ref()?.points();
        Some(self.body.as_ref()?.permit_among(points, wanted, &ability))
    }

    /// The mean of the samples.
    fn plan(&mut self, cx: &Context, pose: &Pose2D) -> Option<Twist> {
        let (base, weights) = (self.ability(cx), self.critics.weights(cx));
        let spread = self.sampling.spread.get(cx) as f32;
        let spread = Spread {
            deviation: [base.fast.max(base.reverse), base.sideways, base.turn].map(|most| spread * most),
            temperature: self.sampling.temperature.get(cx) as f32,
        };
        let surroundings = self.surroundings.as_ref()?;
        let travel = self.body.as_ref()?.travel();
        let start = Motion {
            pose: surroundings.to_window(pose),
            velocity: command(&travel.velocity),
            lead: command(&travel.lead),
        };
        let horizon = self.limits.vx_max.get(cx)
            * self.sampling.model_dt.get(cx)
            * f64::from(self.sampling.time_steps.get(cx));
        let (track, last) = (&self.track, self.track.length());
        let passed = last - track.left();
        let ways = (0..PLACES).map(|at| passed + (horizon + MAX_BEYOND) * f64::from(at) / f64::from(PLACES));
        let ways = ways.take_while(|way| *way < last).chain([last]);
        let places = ways.take(PLACES as usize).map(|way| {
            let [x, y, _] = surroundings.to_window(&track.at(way));
            (x, y)
        });
        self.guide.follow(start.pose, places);
        let situation = Situation {
            start,
            base,
            discs: &self.discs,
            clearance: surroundings.clearance(),
            guide: &self.guide,
            margin: self.obstacles.margin.get(cx) as f32,
            near: self.obstacles.inflation_radius.get(cx) as f32,
            weights,
        };
        let now = cx.now();
        let elapsed = self
            .commanded
            .map_or(Duration::ZERO, |last| now.saturating_sub(last));
        let controller = self.controller.as_mut()?;
        let found = controller.command(&situation, &spread, elapsed.as_secs_f32());
        let [ahead, left, turn] = found.map(f64::from);
        self.planned = Some((base, start));
        let mut wanted = Twist::planar(ahead, turn);
        wanted.linear.y = left;
        Some(wanted)
    }

    fn ability(&self, cx: &Context) -> Base {
        let dynamics = self.robot.dynamics(cx);
        // A trajectory speeds up and slows down alike.
        let change = dynamics.acceleration.min(dynamics.deceleration);
        let turn_change = dynamics.turn_acceleration.min(dynamics.turn_deceleration);
        Base {
            fast: self.limits.vx_max.get(cx) as f32,
            reverse: self.kinematics.reverse.get(cx) as f32,
            sideways: self.kinematics.vy_max.get(cx) as f32,
            turn: self.limits.wz_max.get(cx) as f32,
            turning_radius: self.kinematics.min_turning_r.get(cx) as f32,
            acceleration: change as f32,
            turn_acceleration: turn_change as f32,
            lag: dynamics.lag as f32,
        }
    }

    /// Why the robot does not go on; `None` if it does.
    fn reason(&self) -> Option<String> {
        match self.course {
            Course::Missing => Some("no path, pose, usable scan or dynamics of the base".into()),
            Course::Done => Some("at the end of the path".into()),
            Course::Along(..) | Course::Heading(..) => self.permit?.obstacle(),
        }
    }
}

fn command(twist: &Twist) -> Command {
    [twist.linear.x, twist.linear.y, twist.angular.z].map(|part| part as f32)
}

#[cfg(test)]
mod tests;
