//! The configuration of a robot: body, motors, wheels, and the errors of its odometry.
//!
//! The defaults are those of a Pioneer P3-DX; each has its source beside it.

use crate::battery::BATTERY_CAPACITY;
use crate::drive::Kinematics;
use crate::error::{WorldError, check};
use crate::footprint::Footprint;
use crate::head::HeadConfig;

/// Where a robot's odometry starts.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum OdometryOrigin {
    /// At zero, wherever the robot is: like a real robot when it is switched on.
    #[default]
    Zero,
    /// At the start pose of the world file: the odometry's frame is then the world's, except for its drift.
    StartPose,
}

/// A robot's body, motors and wheels.
#[derive(Clone, Debug, PartialEq)]
pub struct RobotConfig {
    /// The outline of the body.
    pub footprint: Footprint,
    /// The motions that its wheels allow.
    pub kinematics: Kinematics,
    /// Greatest speed in m/s, ahead and backwards.
    pub max_linear: f64,
    /// Greatest turn rate in rad/s, either way.
    pub max_angular: f64,
    /// Greatest gain of speed in m/s².
    pub linear_acceleration: f64,
    /// Greatest loss of speed in m/s².
    pub linear_deceleration: f64,
    /// Greatest gain of turn rate in rad/s².
    pub angular_acceleration: f64,
    /// Greatest loss of turn rate in rad/s².
    pub angular_deceleration: f64,
    /// The time constant in seconds by which speeds lag behind what the accelerations allow; 0 for none.
    pub lag: f64,
    /// A command whose speeds, ahead and to the side, are below this one does not move the base, in m/s, unless it turns
    /// the base: friction holds it.
    pub dead_band: f64,
    /// The same of the turn rate of a command, in rad/s. A car has none.
    pub turn_dead_band: f64,
    /// The part of each turn that the wheels lose by skidding, as those of a base with four fixed wheels do. The
    /// odometry measures the wheels.
    pub skid: f64,
    /// The seconds for which the world remembers where the robot was: at least the turn of a [`crate::LaserTurn`].
    pub trail: f64,
    /// Distance between the wheels in metres. The odometry of a car uses the wheels of its rear axle, that of
    /// an omnidirectional robot two imaginary wheels ahead and one to the side.
    pub track: f64,
    /// Encoder ticks for each metre that a wheel rolls.
    pub ticks_per_meter: f64,
    /// Standard deviation of each wheel's constant scale error, as a fraction; drawn once from the seed.
    pub wheel_scale_sigma: f64,
    /// Standard deviation of each wheel's slip after one metre, in metres. It grows with the root of the
    /// distance.
    pub slip_sigma: f64,
    /// Where the odometry starts.
    pub odometry_origin: OdometryOrigin,
    /// The heaviest load that it can push, in kilograms. That load halves its speed.
    pub max_push: f64,
    /// The pan-tilt head.
    pub head: HeadConfig,
    /// Ampere hours of a full battery.
    pub battery_capacity: f64,
}

impl Default for RobotConfig {
    fn default() -> Self {
        Self {
            // RobotRadius of ARIA's p3dx.p.
            footprint: Footprint::Circle { radius: 0.25 },
            kinematics: Kinematics::Differential,
            // The data sheet of the P3-DX: 1.2 m/s and 300 degrees a second.
            max_linear: 1.2,
            max_angular: 300f64.to_radians(),
            // The firmware's factory values: 300 mm/s² and 100 degrees/s², both ways.
            linear_acceleration: 0.3,
            linear_deceleration: 0.3,
            angular_acceleration: 100f64.to_radians(),
            angular_deceleration: 100f64.to_radians(),
            lag: 0.0,
            dead_band: 0.0,
            turn_dead_band: 0.0,
            skid: 0.0,
            trail: 0.0,
            // DiffConvFactor of p3dx.p is 0.0056 rad per mm: the track is twice its inverse.
            track: 2.0 / 5.6,
            // The firmware's ticksmm of a P3-DX.
            ticks_per_meter: 128_000.0,
            // The residual after a careful calibration of the wheels (UMBmark): a few centimetres in a room.
            wheel_scale_sigma: 0.0002,
            slip_sigma: 0.0005,
            odometry_origin: OdometryOrigin::default(),
            // The payload of the data sheet: the robot can push what it can carry.
            max_push: 23.0,
            head: HeadConfig::default(),
            battery_capacity: BATTERY_CAPACITY,
        }
    }
}

impl RobotConfig {
    /// Returns the part of a turn of the wheels that the base makes.
    pub(crate) fn grip(&self) -> f64 {
        1.0 - self.skid
    }

    /// Checks every number.
    ///
    /// # Errors
    /// The first number that is invalid.
    pub fn check(&self) -> Result<(), WorldError> {
        let positive = |value: f64| value > 0.0;
        let not_negative = |value: f64| value >= 0.0;
        self.footprint.check()?;
        self.kinematics.check()?;
        check("lag", self.lag, "0 to 10 s", |value| {
            (0.0..=10.0).contains(&value)
        })?;
        check("dead_band", self.dead_band, "0 to 1 m/s", |value| {
            (0.0..=1.0).contains(&value)
        })?;
        check("turn_dead_band", self.turn_dead_band, "0 to 10 rad/s", |value| {
            (0.0..=10.0).contains(&value)
        })?;
        check("skid", self.skid, "0 to 0.9", |value| {
            (0.0..=0.9).contains(&value)
        })?;
        check("trail", self.trail, "0 to 1 s", |value| {
            (0.0..=1.0).contains(&value)
        })?;
        check(
            "max_linear",
            self.max_linear,
            "more than 0 and at most 20 m/s",
            |value| value > 0.0 && value <= 20.0,
        )?;
        check(
            "max_angular",
            self.max_angular,
            "more than 0 and at most 100 rad/s",
            |value| value > 0.0 && value <= 100.0,
        )?;
        check(
            "linear_acceleration",
            self.linear_acceleration,
            "more than 0 m/s²",
            positive,
        )?;
        check(
            "linear_deceleration",
            self.linear_deceleration,
            "more than 0 m/s²",
            positive,
        )?;
        check(
            "angular_acceleration",
            self.angular_acceleration,
            "more than 0 rad/s²",
            positive,
        )?;
        check(
            "angular_deceleration",
            self.angular_deceleration,
            "more than 0 rad/s²",
            positive,
        )?;
        check("track", self.track, "more than 0 m", positive)?;
        check(
            "ticks_per_meter",
            self.ticks_per_meter,
            "1 to 1e9 ticks",
            |value| (1.0..=1e9).contains(&value),
        )?;
        check("wheel_scale_sigma", self.wheel_scale_sigma, "0 to 0.5", |value| {
            (0.0..=0.5).contains(&value)
        })?;
        check("slip_sigma", self.slip_sigma, "0 m or more", not_negative)?;
        check("max_push", self.max_push, "more than 0 kg", positive)?;
        check(
            "battery_capacity",
            self.battery_capacity,
            "more than 0 Ah",
            positive,
        )?;
        self.head.check()
    }
}
