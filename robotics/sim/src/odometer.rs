//! Wheel encoders, and the pose that a robot computes from them.
//!
//! It depends on the rotation of the wheels only, not on the pose of the robot.

use crate::config::RobotConfig;
use crate::drift::{Covariance, Drift, MeasuredMotion};
use crate::geometry::{Pose2, Twist2};
use crate::random::Noise;

/// The measurement of the wheels: a pose that drifts, and the twist of the last step.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Odometry {
    /// The pose in the frame of the odometry. [`crate::OdometryOrigin`] defines its origin.
    pub pose: Pose2,
    /// The twist over the last step of the world, in the robot's frame, with the resolution of the encoders.
    pub twist: Twist2,
}

/// How far the odometry may be from the true motion, by the errors that the robot's file states. Rows are x, y and
/// the heading.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct OdometryCovariance {
    /// Of the pose, since the odometry was zero: m², m rad and rad².
    pub pose: Covariance,
    /// Of the twist, in the robot's frame: m²/s², m rad/s² and rad²/s².
    pub twist: Covariance,
}

/// The ticks since the robot was added to the world; they decrease backwards.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Encoders {
    /// The left wheel.
    pub left: i64,
    /// The right wheel.
    pub right: i64,
}

#[derive(Debug)]
struct LateralWheel {
    rolled: f64,
    ticks: i64,
    scale: f64,
}

#[derive(Debug)]
pub(crate) struct Odometer {
    pub(crate) odometry: Odometry,
    pub(crate) encoders: Encoders,
    drift: Drift,
    /// Metres that each wheel measured, without the rounding to ticks.
    rolled: [f64; 2],
    /// The measured length of one metre, for each wheel.
    scale: [f64; 2],
    /// The wheel of an omnidirectional robot that rolls to the left.
    lateral: LateralWheel,
}

impl Odometer {
    pub(crate) fn new(config: &RobotConfig, origin: Pose2, noise: &Noise) -> Self {
        let scale = noise
            .normals(0)
            .map(|normal| 1.0 + config.wheel_scale_sigma * normal);
        Self {
            odometry: Odometry {
                pose: origin,
                twist: Twist2::default(),
            },
            encoders: Encoders::default(),
            drift: Drift::default(),
            rolled: [0.0; 2],
            scale,
            lateral: LateralWheel {
                rolled: 0.0,
                ticks: 0,
                scale: 1.0 + config.wheel_scale_sigma * noise.normals(1)[0],
            },
        }
    }

    /// Sets the pose and its covariance to zero. The ticks continue.
    pub(crate) fn reset(&mut self) {
        self.odometry.pose = Pose2::default();
        self.drift.reset();
    }

    pub(crate) fn covariance(&self, config: &RobotConfig) -> OdometryCovariance {
        OdometryCovariance {
            pose: self.drift.pose(config),
            twist: self.drift.twist(config),
        }
    }

    /// Measures a true motion of metres ahead and to the left, and of `turn` radians, that took `dt` seconds. What the wheels
    /// skid counts as rolled, as for any encoder.
    pub(crate) fn roll(
        &mut self,
        config: &RobotConfig,
        [distance, left]: [f64; 2],
        turn: f64,
        dt: f64,
        noise: &Noise,
    ) {
        let aside = self.lateral.roll(config, left, noise);
        let side = turn / config.grip() * config.track / 2.0;
        let slip = noise.normals(0);
        let before = self.encoders;
        for (wheel, way) in [distance - side, distance + side].into_iter().enumerate() {
            self.rolled[wheel] +=
                self.scale[wheel] * way + config.slip_sigma * way.abs().sqrt() * slip[wheel];
        }
        let ticks = self
            .rolled
            .map(|metres| libm::floor(metres * config.ticks_per_meter) as i64);
        self.encoders = Encoders {
            left: ticks[0],
            right: ticks[1],
        };
        let left = (self.encoders.left - before.left) as f64 / config.ticks_per_meter;
        let right = (self.encoders.right - before.right) as f64 / config.ticks_per_meter;
        let (ahead, turned) = ((left + right) / 2.0, (right - left) / config.track);
        let from = self.odometry.pose;
        let to = from.along([ahead, aside], turned);
        let step = MeasuredMotion {
            heading: from.heading + turned / 2.0,
            moved: [to.x - from.x, to.y - from.y],
            ways: [left, right, aside],
            dt,
        };
        self.drift.add(config.track, step);
        self.odometry.pose = to;
        self.odometry.twist = Twist2 {
            linear: ahead / dt,
            lateral: aside / dt,
            angular: turned / dt,
        };
    }
}

impl LateralWheel {
    /// Returns the metres that it measured of a true motion to the left.
    fn roll(&mut self, config: &RobotConfig, way: f64, noise: &Noise) -> f64 {
        if way == 0.0 {
            return 0.0;
        }
        self.rolled += self.scale * way + config.slip_sigma * way.abs().sqrt() * noise.normals(1)[0];
        let before = self.ticks;
        self.ticks = libm::floor(self.rolled * config.ticks_per_meter) as i64;
        (self.ticks - before) as f64 / config.ticks_per_meter
    }
}
