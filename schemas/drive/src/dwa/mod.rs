//! The dynamic window approach: Fox, Burgard and Thrun, "The dynamic window approach to collision avoidance",
//! IEEE Robotics and Automation Magazine, 1997, with the costs of ROS's `base_local_planner`: of the velocities
//! that the base can reach, it takes the one whose arc ends nearest to the path and farthest along it.

mod panel;
mod sampling;
mod window;

use jde_motion::Travel;
use jde_schema::prelude::*;
use jde_schema::types::OccupancyGrid;

use crate::body::{Body, Permit};
use crate::ports::{PathGoal, Perception, RobotBase, VelocityLimits};
use crate::track::Track;
use sampling::{Samples, Scene, Weights};
use window::{Perimeter, Window};

/// How long the base accelerates before the next choice, s: the default period.
const PERIOD: f64 = 0.05;

/// Follows a path among the obstacles of a map by the best of many arcs.
///
/// It is ready while it has a path, a pose on a map, and a scan with a measurement. The arcs avoid the obstacles of
/// the map; before the command acts, it is checked against the newest scan. If every arc touches something, it backs
/// with `escape` as far as the map is free, or stands and states the reason.
#[derive(Describe)]
#[schema(motor, period = "50ms", budget = "20ms")]
pub struct Dwa {
    #[ports]
    perception: Perception,
    /// The path, in the frame of the pose.
    #[import]
    path: Import<jde_schema::types::Path>,
    /// The map, in the frame of the pose.
    #[import]
    map: Import<OccupancyGrid>,
    #[ports]
    goal: PathGoal,
    /// Way along the path to the point that arcs are to reach.
    #[modulation(default = 2.0, unit = "m", min = 0.1, max = 10.0)]
    ahead: Modulation<f64>,
    /// How long an arc is simulated.
    #[modulation(default = 2.0, unit = "s", min = 0.1, max = 10.0, was = "horizon")]
    sim_time: Modulation<f64>,
    /// How many speeds are tried.
    #[modulation(default = 6, min = 2, max = 100, was = "speeds")]
    vx_samples: Modulation<u32>,
    /// How many turn rates are tried at each speed.
    #[modulation(default = 20, min = 2, max = 100, was = "turns")]
    vtheta_samples: Modulation<u32>,
    /// Least speed ahead.
    #[modulation(default = 0.1, unit = "m/s", min = 0.0, was = "slow")]
    vx_min: Modulation<f64>,
    #[ports]
    limits: VelocityLimits,
    /// Speed back if every arc touches something.
    #[modulation(default = 0.1, unit = "m/s", min = 0.0)]
    escape: Modulation<f64>,
    /// Cost of a metre between the end of an arc and the path.
    #[modulation(default = 15.0, unit = "1/m", min = 0.0, was = "path_weight")]
    path_distance_bias: Modulation<f64>,
    /// Cost of a metre between the end of an arc and the point to reach.
    #[modulation(default = 20.0, unit = "1/m", min = 0.0, was = "goal_weight")]
    goal_distance_bias: Modulation<f64>,
    /// Cost of an arc on which the outline almost touches an obstacle.
    #[modulation(default = 2.0, min = 0.0, was = "obstacle_weight")]
    occdist_scale: Modulation<f64>,
    /// Distance from the padded outline beyond which an obstacle costs nothing.
    #[modulation(default = 0.3, unit = "m", min = 0.0, max = 5.0, was = "reach")]
    inflation_radius: Modulation<f64>,
    /// Rate at which costs decay with the distance to an obstacle.
    #[modulation(default = 10.0, unit = "1/m", min = 0.0, max = 100.0, was = "decay")]
    cost_scaling_factor: Modulation<f64>,
    #[ports]
    robot: RobotBase,
    /// How much larger the outline counts among the obstacles of the map.
    #[modulation(default = 0.05, unit = "m", min = 0.0, max = 1.0, fixed, was = "padding")]
    footprint_padding: Modulation<f64>,
    /// Distance to keep from everything that the laser sees.
    #[modulation(default = 0.05, unit = "m", min = 0.0, margin)]
    margin: Modulation<f64>,
    /// How long a command is in force before the next one takes effect.
    #[modulation(default = 0.2, unit = "s", min = 0.0, max = 10.0)]
    reaction: Modulation<f64>,
    body: Option<Body>,
    perimeter: Option<Perimeter>,
    window: Option<Window>,
    track: Track,
    /// The end of the chosen arc.
    end: Option<Pose2D>,
    pursuit: Pursuit,
    permit: Option<Permit>,
    /// The side to which it turns on the spot; 0 if it drives.
    spin: f64,
}

/// What the robot does about its path.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
enum Pursuit {
    /// There is no path, no pose, no map, no usable scan or no dynamics of the base.
    #[default]
    Missing,
    /// It follows an arc.
    Arc,
    /// Every arc touches something.
    Enclosed,
    /// It is at the end, and turns on the spot to the last heading.
    Heading,
    /// It is at the end of the path.
    Done,
}

impl Schema for Dwa {
    fn awake(&mut self, cx: &Context) -> Result {
        self.body = Some(self.robot.body(cx)?);
        self.perimeter = None;
        self.track = Track::default();
        self.spin = 0.0;
        Ok(())
    }

    fn check(&mut self, cx: &Context) -> Result<Precondition> {
        Ok(self.observe(cx).is_some().into())
    }

    fn iterate(&mut self, cx: &Context) -> Result {
        let twist = self.decide(cx);
        self.robot.base.command(cx, twist);
        let is_done = self.pursuit == Pursuit::Done;
        let note = self.reason().unwrap_or_default();
        self.goal.mission.write(cx, self.track.mission(is_done, &note));
        Ok(())
    }
}

/// Refuses a footprint that is no convex area.
impl Inspect for Dwa {
    fn inspect(&self, cx: &Context, problems: &mut Problems) {
        self.robot.inspect(cx, problems);
    }
}

impl Dwa {
    /// Takes in scan, pose, path and map; returns how the base moves, or `None` if one of them or the dynamics of the
    /// base are missing, or the robot is not on the map.
    fn observe(&mut self, cx: &Context) -> Option<Travel> {
        let (laser, odometry) = (self.perception.laser.get(cx), self.perception.pose.get(cx));
        let body = self.body.as_mut()?;
        let (pose, _) = body.observe(cx, laser.as_ref(), odometry.as_ref(), self.robot.motors(cx))?;
        let path = self.path.get(cx)?;
        let poses = path.poses.iter().map(|stamped| stamped.pose.into());
        let is_followed = self.track.replace(poses);
        let map = self.map.get(cx)?;
        (is_followed && window::place(&map, &pose).is_some()).then_some(*body.travel())
    }

    /// Returns the command.
    fn decide(&mut self, cx: &Context) -> Twist {
        (self.end, self.permit) = (None, None);
        let Some(now) = self.observe(cx) else {
            self.pursuit = Pursuit::Missing;
            return Twist::ZERO;
        };
        self.track.advance(&now.pose);
        let samples = self.samples(cx);
        let goal = self.track.goal();
        let wanted = if now.pose.distance_to(&goal) > self.goal.xy_goal_tolerance.get(cx) {
            self.choose(cx, &now, &samples)
        } else if let Some(angle) = self.goal.turn(cx, now.pose.theta, &goal) {
            self.pursuit = Pursuit::Heading;
            Some(
                self.limits
                    .spot(cx, angle, self.goal.min_in_place_vel_theta.get(cx)),
            )
        } else {
            self.pursuit = Pursuit::Done;
            None
        };
        let (Some(twist), Some(body)) = (wanted, &self.body) else {
            return Twist::ZERO;
        };
        let ability = self.robot.ability(cx, self.margin.get(cx), self.reaction.get(cx));
        let permit = body.permit(twist, &ability);
        self.permit = Some(permit);
        self.spin = match permit {
            _ if twist.linear.x != 0.0 => 0.0,
            Permit::Stay(_) => -twist.angular.z.signum(),
            Permit::Go(_) | Permit::Turn(..) | Permit::Unknown => twist.angular.z.signum(),
        };
        permit.twist()
    }

    /// Returns the best velocity; `None` if the map has no way.
    fn choose(&mut self, cx: &Context, now: &Travel, samples: &Samples) -> Option<Twist> {
        self.pursuit = Pursuit::Missing;
        let map = self.map.get(cx)?;
        let half =
            samples.speed.1 * samples.horizon + self.body.as_ref()?.reach() + self.footprint_padding.get(cx);
        let costs = (self.inflation_radius.get(cx), self.cost_scaling_factor.get(cx));
        // It refuses a map that is none, before anything is computed from its numbers.
        self.window = Window::new(&map, &now.pose, half, costs);
        let window = self.window.as_ref()?;
        let resolution = f64::from(map.info.resolution);
        if self.perimeter.as_ref().map(Perimeter::spacing) != Some(resolution) {
            let (footprint, padding) = (self.robot.footprint.get(cx), self.footprint_padding.get(cx));
            self.perimeter = Some(Perimeter::new(&footprint, padding, resolution));
        }
        let (perimeter, track) = (self.perimeter.as_ref()?, &self.track);
        let scene = Scene {
            window,
            perimeter,
            track,
            touching: window.contact(&now.pose, perimeter).touching,
            goal: track.length() - (track.left() - self.ahead.get(cx)).max(0.0),
            weights: Weights {
                path: self.path_distance_bias.get(cx),
                goal: self.goal_distance_bias.get(cx),
                obstacle: self.occdist_scale.get(cx),
            },
        };
        self.pursuit = Pursuit::Arc;
        let best = samples.best(now, &scene).or_else(|| {
            self.pursuit = Pursuit::Enclosed;
            let back = Twist::planar(-self.escape.get(cx), 0.0);
            samples.choice(now, back, &scene)
        });
        self.end = best.as_ref().map(|choice| choice.end);
        best.map(|choice| choice.twist)
    }

    fn samples(&self, cx: &Context) -> Samples {
        Samples {
            count: (self.vx_samples.get(cx), self.vtheta_samples.get(cx)),
            speed: (
                self.vx_min.get(cx).min(self.limits.vx_max.get(cx)),
                self.limits.vx_max.get(cx),
            ),
            turn: (
                self.goal.min_in_place_vel_theta.get(cx),
                self.limits.wz_max.get(cx),
            ),
            dynamics: self.robot.dynamics(cx),
            period: PERIOD,
            horizon: self.sim_time.get(cx),
            spin: self.spin,
        }
    }

    /// Why the robot does not go on; `None` if it does.
    fn reason(&self) -> Option<String> {
        match self.pursuit {
            Pursuit::Missing => Some("no path, pose, map around it, usable scan or dynamics".into()),
            Pursuit::Enclosed => Some("every arc touches something".into()),
            Pursuit::Done => Some("at the end of the path".into()),
            Pursuit::Arc | Pursuit::Heading => self.permit?.obstacle(),
        }
    }
}

#[cfg(test)]
mod tests;
