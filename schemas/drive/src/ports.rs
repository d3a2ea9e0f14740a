//! The ports that several schemas of this plugin have.

use jde_motion::{BaseDynamics, FootprintError, Motors};
use jde_schema::prelude::*;
use jde_schema::types::{Footprint, normalize_angle};

use crate::body::{Ability, Body};

/// Turn rate for a heading error of 1 rad while it turns on the spot, 1/s.
const SPOT_GAIN: f64 = 2.0;

/// What a schema knows of the robot and of what is around it.
#[derive(PortBundle)]
pub(crate) struct Perception {
    /// The scan of the laser.
    #[import(trigger)]
    pub(crate) laser: Import<LaserScan>,
    /// The estimated pose and velocity of the robot.
    #[import]
    pub(crate) pose: Import<Odometry>,
}

/// The base that a schema drives: its outline, its laser, what it can do, and its speeds.
#[derive(PortBundle)]
pub(crate) struct RobotBase {
    /// The outline of the robot.
    #[modulation(default = Footprint::circle(0.25), fixed)]
    pub(crate) footprint: Modulation<Footprint>,
    /// Where the laser is on the base.
    #[modulation(default = Pose2D::ORIGIN, fixed, mount)]
    pub(crate) mount: Modulation<Pose2D>,
    /// Greatest change of speed of the base.
    #[modulation(default = 0.3, unit = "m/s2", min = 0.01, limit, was = "acceleration")]
    pub(crate) ax_max: Modulation<f64>,
    /// Greatest change of turn rate of the base.
    #[modulation(default = 1.0, unit = "rad/s2", min = 0.01, limit, was = "turn_acceleration")]
    pub(crate) az_max: Modulation<f64>,
    /// Time constant by which the speeds of the base follow a command.
    #[modulation(default = 0.0, unit = "s", min = 0.0, max = 2.0)]
    pub(crate) lag: Modulation<f64>,
    /// How the base follows its commands, from its driver. The numbers that it knows count instead of `ax_max`, `az_max`
    /// and `lag`.
    #[import(optional)]
    pub(crate) dynamics: Import<BaseDynamics>,
    /// What the driver leads the base to at present. Without it, it is estimated from the odometry.
    #[import(optional)]
    pub(crate) setpoint: Import<Twist>,
    /// Speeds of the base.
    #[actuator]
    pub(crate) base: Actuator<Twist>,
}

/// How fast a schema drives.
#[derive(PortBundle)]
pub(crate) struct VelocityLimits {
    /// Greatest speed.
    #[modulation(default = 0.4, unit = "m/s", min = 0.0, limit, was = "fast")]
    pub(crate) vx_max: Modulation<f64>,
    /// Greatest turn rate.
    #[modulation(default = 50_f64.to_radians(), unit = "rad/s", min = 0.01, limit, was = "turn")]
    pub(crate) wz_max: Modulation<f64>,
}

/// The path that a schema follows.
#[derive(PortBundle)]
pub(crate) struct PathToFollow {
    /// The path.
    #[import(optional)]
    pub(crate) path: Import<Path>,
    /// The path if the import is not bound.
    #[modulation(default = Route::EMPTY)]
    pub(crate) route: Modulation<Route>,
}

/// The end of that path.
#[derive(PortBundle)]
pub(crate) struct PathGoal {
    /// Distance to the end of the path below which it is reached.
    #[modulation(default = 0.15, unit = "m", min = 0.01, was = "tolerance")]
    pub(crate) xy_goal_tolerance: Modulation<f64>,
    /// Error of the last heading below which it is reached. "180 deg" accepts any heading.
    #[modulation(default = 0.25, unit = "rad", min = 0.01, was = "heading_tolerance")]
    pub(crate) yaw_goal_tolerance: Modulation<f64>,
    /// Least turn rate on the spot: above the dead band of the base.
    #[modulation(default = 0.3, unit = "rad/s", min = 0.0, was = "spot_turn")]
    pub(crate) min_in_place_vel_theta: Modulation<f64>,
    /// Done at the end of the path. The distance is the way to it; the note states why the robot stands.
    #[export(lasting)]
    pub(crate) mission: Export<Mission>,
}

impl VelocityLimits {
    /// Returns the turn on the spot by this angle to the left, rad, at `least` rad/s or more.
    pub(crate) fn spot(&self, cx: &Context, angle: f64, least: f64) -> Twist {
        let most = self.wz_max.get(cx);
        let rate = (SPOT_GAIN * angle.abs()).clamp(least.min(most), most);
        Twist::planar(0.0, rate.copysign(angle))
    }
}

impl PathGoal {
    /// Returns by which angle to the left the robot must turn at the end of the path, rad; `None` if it faces as it must.
    pub(crate) fn turn(&self, cx: &Context, heading: f64, goal: &Pose2D) -> Option<f64> {
        let error = normalize_angle(goal.theta - heading);
        (error.abs() > self.yaw_goal_tolerance.get(cx)).then_some(error)
    }
}

impl RobotBase {
    /// Returns the body with its laser.
    pub(crate) fn body(&self, cx: &Context) -> Result<Body, FootprintError> {
        Body::new(&self.footprint.get(cx), self.mount.get(cx))
    }

    /// Reports a footprint that is none.
    pub(crate) fn inspect(&self, cx: &Context, problems: &mut Problems) {
        problems.expect(&self.footprint, self.body(cx));
    }

    /// Returns how the base follows its commands.
    pub(crate) fn dynamics(&self, cx: &Context) -> BaseDynamics {
        let (change, turn_change) = (self.ax_max.get(cx), self.az_max.get(cx));
        let stated = BaseDynamics {
            acceleration: change,
            deceleration: change,
            turn_acceleration: turn_change,
            turn_deceleration: turn_change,
            lag: self.lag.get(cx),
        };
        self.dynamics.get(cx).map_or(stated, |known| known.or(&stated))
    }

    /// Returns what is known of the motors of the base; `None` as long as its driver states no dynamics although they
    /// are bound, or a number of them is not valid.
    pub(crate) fn motors(&self, cx: &Context) -> Option<Motors> {
        if self.dynamics.is_bound(cx) {
            self.dynamics.get(cx)?;
        }
        let dynamics = self.dynamics(cx);
        dynamics.check().ok()?;
        let setpoint = self.setpoint.get(cx);
        let setpoint = setpoint.map(|setpoint| (*setpoint, setpoint.age(cx)));
        Some(Motors::new(dynamics, setpoint))
    }

    /// Returns what the base can do, at this distance from everything, m, with commands that hold for this time, s.
    pub(crate) fn ability(&self, cx: &Context, margin: f64, hold: f64) -> Ability {
        Ability {
            dynamics: self.dynamics(cx),
            margin,
            hold,
        }
    }
}
