//! The dynamic window approach: Fox, Burgard and Thrun, "The dynamic window approach to collision avoidance",
//! IEEE Robotics and Automation Magazine, 1997, with the costs of ROS's `base_local_planner`: of the velocities
//! that the base can reach, it takes the one whose arc ends nearest to the path and farthest along it.

mod panel;
mod sampling;
mod window;

use jde_motion::{Limits, Travel};
use jde_schema::prelude::*;
use jde_schema::types::{Footprint, OccupancyGrid};

use crate::body::{Ability, Body, Permit};
use crate::track::Track;
use sampling::{Samples, Scene, Weights};
use window::{Perimeter, Window};

/// How long the base accelerates before the next choice, s: the default period.
const PERIOD: f64 = 0.05;

/// Follows a path among the obstacles of a map by the best of many arcs.
///
/// It is ready while it has a path, a pose on a map, and a scan that measures something. The arcs avoid what the
/// map has; before the command acts, it is checked against the newest scan. If every arc touches something, it
/// backs with `escape` as far as the map is free, or stands and states the reason.
#[derive(Describe)]
#[schema(motor, period = "50ms", budget = "20ms")]
pub struct Dwa {
    /// The scan of the laser.
    #[import(trigger)]
    laser: Import<LaserScan>,
    /// The estimated pose and velocity of the robot.
    #[import]
    pose: Import<Odometry>,
    /// The path, in the frame of the pose.
    #[import]
    path: Import<jde_schema::types::Path>,
    /// The map, in the frame of the pose.
    #[import]
    map: Import<OccupancyGrid>,
    /// Distance to the end of the path below which it is reached.
    #[modulation(default = 0.15, unit = "m", min = 0.01)]
    tolerance: Modulation<f64>,
    /// Way along the path to the point that arcs are to reach.
    #[modulation(default = 2.0, unit = "m", min = 0.1, max = 10.0)]
    ahead: Modulation<f64>,
    /// How long an arc is simulated.
    #[modulation(default = 2.0, unit = "s", min = 0.1, max = 10.0)]
    horizon: Modulation<f64>,
    /// How many speeds are tried.
    #[modulation(default = 6, min = 2, max = 100)]
    speeds: Modulation<u32>,
    /// How many turn rates are tried at each speed.
    #[modulation(default = 20, min = 2, max = 100)]
    turns: Modulation<u32>,
    /// Least speed ahead.
    #[modulation(default = 0.1, unit = "m/s", min = 0.0)]
    slow: Modulation<f64>,
    /// Greatest speed.
    #[modulation(default = 0.4, unit = "m/s", min = 0.0)]
    fast: Modulation<f64>,
    /// Greatest turn rate.
    #[modulation(default = 50_f64.to_radians(), unit = "rad/s", min = 0.01)]
    turn: Modulation<f64>,
    /// Least turn rate on the spot.
    #[modulation(default = 0.3, unit = "rad/s", min = 0.0)]
    spot_turn: Modulation<f64>,
    /// Speed back if every arc touches something.
    #[modulation(default = 0.1, unit = "m/s", min = 0.0)]
    escape: Modulation<f64>,
    /// Cost of a metre between the end of an arc and the path.
    #[modulation(default = 15.0, unit = "1/m", min = 0.0)]
    path_weight: Modulation<f64>,
    /// Cost of a metre between the end of an arc and the point to reach.
    #[modulation(default = 20.0, unit = "1/m", min = 0.0)]
    goal_weight: Modulation<f64>,
    /// Cost of an arc on which the outline almost touches an obstacle.
    #[modulation(default = 2.0, min = 0.0)]
    obstacle_weight: Modulation<f64>,
    /// Distance from the padded outline to an obstacle from which on it costs nothing.
    #[modulation(default = 0.3, unit = "m", min = 0.0, max = 5.0)]
    reach: Modulation<f64>,
    /// Rate at which costs decay with the distance to an obstacle.
    #[modulation(default = 10.0, unit = "1/m", min = 0.0, max = 100.0)]
    decay: Modulation<f64>,
    /// The outline of the robot.
    #[modulation(default = Footprint::circle(0.25), fixed)]
    footprint: Modulation<Footprint>,
    /// How much larger the outline counts among the obstacles of the map.
    #[modulation(default = 0.05, unit = "m", min = 0.0, max = 1.0, fixed)]
    padding: Modulation<f64>,
    /// Where the laser is on the base.
    #[modulation(default = Pose2D::ORIGIN, fixed)]
    mount: Modulation<Pose2D>,
    /// Distance to keep from what the laser sees.
    #[modulation(default = 0.02, unit = "m", min = 0.0)]
    margin: Modulation<f64>,
    /// How long a command is in force before the next one takes effect.
    #[modulation(default = 0.2, unit = "s", min = 0.0, max = 10.0)]
    reaction: Modulation<f64>,
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
    /// There is no path, no pose, no map or no usable scan.
    #[default]
    Missing,
    /// It follows an arc.
    Arc,
    /// Every arc touches something.
    Enclosed,
    /// It is at the end of the path.
    Done,
}

impl Schema for Dwa {
    fn awake(&mut self, cx: &Context) -> Result {
        self.body = Some(Body::new(&self.footprint.get(cx), self.mount.get(cx))?);
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
        self.base.command(cx, twist);
        let is_done = self.pursuit == Pursuit::Done;
        let note = self.reason().unwrap_or_default();
        self.mission.write(cx, self.track.mission(is_done, &note));
        Ok(())
    }
}

/// Refuses a footprint that is no convex area.
impl Inspect for Dwa {
    fn inspect(&self, cx: &Context, problems: &mut Problems) {
        problems.expect(
            &self.footprint,
            Body::new(&self.footprint.get(cx), self.mount.get(cx)),
        );
    }
}

impl Dwa {
    /// Takes in scan, pose, path and map; returns how the base moves, or `None` if one of them is missing or the
    /// robot is not on the map.
    fn observe(&mut self, cx: &Context) -> Option<Travel> {
        let (laser, odometry) = (self.laser.get(cx), self.pose.get(cx));
        let body = self.body.as_mut()?;
        let (pose, velocity) = body.observe(laser.as_deref(), odometry.as_deref())?;
        let path = self.path.get(cx)?;
        let poses = path.poses.iter().map(|stamped| stamped.pose.into());
        let is_followed = self.track.replace(poses);
        let map = self.map.get(cx)?;
        (is_followed && window::place(&map, &pose).is_some()).then_some(Travel { pose, velocity })
    }

    /// Returns the command.
    fn decide(&mut self, cx: &Context) -> Twist {
        (self.end, self.permit) = (None, None);
        let Some(now) = self.observe(cx) else {
            self.pursuit = Pursuit::Missing;
            return Twist::ZERO;
        };
        self.track.advance(&now.pose);
        if now.pose.distance_to(&self.track.goal()) <= self.tolerance.get(cx) {
            self.pursuit = Pursuit::Done;
            return Twist::ZERO;
        }
        let samples = self.samples(cx);
        let wanted = self.choose(cx, &now, &samples);
        let (Some(twist), Some(body)) = (wanted, &self.body) else {
            return Twist::ZERO;
        };
        let ability = Ability {
            acceleration: samples.limits.acceleration,
            turn_acceleration: samples.limits.turn_acceleration,
            margin: self.margin.get(cx),
            hold: self.reaction.get(cx),
        };
        let permit = body.permit(&now.velocity, twist, &ability);
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
        let half = samples.speed.1 * samples.horizon + self.body.as_ref()?.reach() + self.padding.get(cx);
        let costs = (self.reach.get(cx), self.decay.get(cx));
        // It refuses a map that is none, before anything is computed from its numbers.
        self.window = Window::new(&map, &now.pose, half, costs);
        let window = self.window.as_ref()?;
        let resolution = f64::from(map.info.resolution);
        if self.perimeter.as_ref().map(Perimeter::spacing) != Some(resolution) {
            let (footprint, padding) = (self.footprint.get(cx), self.padding.get(cx));
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
                path: self.path_weight.get(cx),
                goal: self.goal_weight.get(cx),
                obstacle: self.obstacle_weight.get(cx),
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
        let (acceleration, turn_acceleration) = (self.acceleration.get(cx), self.turn_acceleration.get(cx));
        Samples {
            count: (self.speeds.get(cx), self.turns.get(cx)),
            speed: (self.slow.get(cx).min(self.fast.get(cx)), self.fast.get(cx)),
            turn: (self.spot_turn.get(cx), self.turn.get(cx)),
            limits: Limits {
                acceleration,
                deceleration: acceleration,
                turn_acceleration,
                turn_deceleration: turn_acceleration,
            },
            period: PERIOD,
            horizon: self.horizon.get(cx),
            spin: self.spin,
        }
    }

    /// Why the robot does not go on; `None` if it does.
    fn reason(&self) -> Option<String> {
        match self.pursuit {
            Pursuit::Missing => Some("no path, no pose, no map around it or no usable scan".into()),
            Pursuit::Enclosed => Some("every arc touches something".into()),
            Pursuit::Done => Some("at the end of the path".into()),
            Pursuit::Arc => self.permit?.obstacle(),
        }
    }
}

#[cfg(test)]
mod tests;
