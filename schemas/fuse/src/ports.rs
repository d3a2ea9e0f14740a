//! The parameters of the filter, by what they are about.

use jde_fuse::{Initial, ProcessNoise, Thresholds};
use jde_schema::prelude::*;
use jde_schema::types::Start;

/// What the orientation of an IMU is used for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Choice)]
#[repr(u8)]
pub(crate) enum HeadingUse {
    /// Nothing.
    None,
    /// The heading in the frame of the export, with `yaw_offset`: of a compass.
    Absolute,
    /// The change of the heading since the first one.
    Relative,
}

/// Where the robot is at first.
#[derive(PortBundle)]
pub(crate) struct InitialPose {
    /// Where the robot is when the schema awakes first: `[[3.55, 1.6, "90 deg"]]`. Without a pose it is where `pose` says, or
    /// `position` with an absolute heading, or else the odometry.
    #[modulation(default = Start::NONE)]
    pub(crate) initial_pose: Modulation<Start>,
    /// Standard deviation of x and y of that pose.
    #[modulation(default = 0.1, unit = "m", min = 0.0, max = 100.0)]
    pub(crate) initial_deviation: Modulation<f64>,
    /// Standard deviation of the heading of that pose.
    #[modulation(default = 5_f64.to_radians(), unit = "rad", min = 0.0, max = 3.15)]
    pub(crate) initial_heading_deviation: Modulation<f64>,
}

/// How the IMU is mounted, and what of it is used.
#[derive(PortBundle)]
pub(crate) struct ImuUse {
    /// Rotation of the IMU on the base about the axis ahead, after the other two; upside down it is 180 degrees.
    #[modulation(default = 0.0, unit = "rad", min = -3.15, max = 3.15)]
    pub(crate) imu_roll: Modulation<f64>,
    /// Rotation of the IMU on the base about the axis to the left.
    #[modulation(default = 0.0, unit = "rad", min = -3.15, max = 3.15)]
    pub(crate) imu_pitch: Modulation<f64>,
    /// Rotation of the IMU on the base about the axis up.
    #[modulation(default = 0.0, unit = "rad", min = -3.15, max = 3.15)]
    pub(crate) imu_yaw: Modulation<f64>,
    /// What the orientation of the IMU is used for. That of a unit without a compass is the integral of its gyro and says
    /// nothing new.
    #[modulation(default = HeadingUse::None)]
    pub(crate) imu_heading: Modulation<HeadingUse>,
    /// What an absolute heading lacks to be that in the frame of the export.
    #[modulation(default = 0.0, unit = "rad", min = -3.15, max = 3.15)]
    pub(crate) yaw_offset: Modulation<f64>,
}

/// Standard deviations of measurements whose sensors state none.
#[derive(PortBundle)]
pub(crate) struct Deviations {
    /// Of the speeds of the odometry.
    #[modulation(default = 0.02, unit = "m/s", min = 0.0001, max = 10.0)]
    pub(crate) odom_speed_deviation: Modulation<f64>,
    /// Of the turn rate of the odometry.
    #[modulation(default = 0.05, unit = "rad/s", min = 0.0001, max = 10.0)]
    pub(crate) odom_turn_rate_deviation: Modulation<f64>,
    /// Of the turn rate of the gyro.
    #[modulation(default = 0.01, unit = "rad/s", min = 0.0001, max = 10.0)]
    pub(crate) imu_turn_rate_deviation: Modulation<f64>,
    /// Of a heading.
    #[modulation(default = 0.05, unit = "rad", min = 0.0001, max = 3.15)]
    pub(crate) heading_deviation: Modulation<f64>,
    /// Of a position.
    #[modulation(default = 0.5, unit = "m", min = 0.001, max = 100.0)]
    pub(crate) position_deviation: Modulation<f64>,
}

/// Standard deviations of constant errors before anything is measured. The errors are estimated.
#[derive(PortBundle)]
pub(crate) struct ConstantErrors {
    /// Of what the gyro shows at rest.
    #[modulation(default = 0.02, unit = "rad/s", min = 0.0, max = 1.0)]
    gyro_bias_deviation: Modulation<f64>,
    /// Of the share by which the wheels measure ways too long or too short.
    #[modulation(default = 0.02, min = 0.0, max = 1.0)]
    scale_deviation: Modulation<f64>,
    /// Of the share by which the wheels measure turns too large or too small: skidding wheels and the distance of the wheels.
    #[modulation(default = 0.1, min = 0.0, max = 1.0)]
    turn_scale_deviation: Modulation<f64>,
    /// Of the turn that the wheels measure for each metre and that is none, because one wheel is larger than the other.
    #[modulation(default = 0.05, unit = "rad/m", min = 0.0, max = 10.0)]
    drift_deviation: Modulation<f64>,
}

/// How fast what is estimated changes without a measurement: the growth of its variance.
#[derive(PortBundle)]
pub(crate) struct Growth {
    /// Of x and y beside the motion.
    #[modulation(default = 1e-6, unit = "m2/s", min = 0.0, max = 10.0)]
    process_noise_x: Modulation<f64>,
    /// Of the heading beside the motion.
    #[modulation(default = 1e-7, unit = "rad2/s", min = 0.0, max = 10.0)]
    process_noise_yaw: Modulation<f64>,
    /// Of the speed ahead.
    #[modulation(default = 0.5, unit = "m2/s3", min = 1e-6, max = 100.0)]
    process_noise_vx: Modulation<f64>,
    /// Of the speed to the left: more for a base that goes sideways.
    #[modulation(default = 0.01, unit = "m2/s3", min = 1e-6, max = 100.0)]
    process_noise_vy: Modulation<f64>,
    /// Of the turn rate.
    #[modulation(default = 0.2, unit = "rad2/s3", min = 1e-6, max = 1000.0)]
    process_noise_vyaw: Modulation<f64>,
    /// Of the gyro's bias.
    #[modulation(default = 1e-7, unit = "rad2/s3", min = 0.0, max = 1.0)]
    process_noise_bias: Modulation<f64>,
}

/// The Mahalanobis distances from which on measurements are refused.
#[derive(PortBundle)]
pub(crate) struct Rejection {
    /// Of the velocity of the odometry: its speeds and its turn rate each.
    #[modulation(default = 5.0, min = 0.1, max = 1e9)]
    odom_twist_rejection_threshold: Modulation<f64>,
    /// Of the turn rate of the gyro.
    #[modulation(default = 8.0, min = 0.1, max = 1e9)]
    imu_twist_rejection_threshold: Modulation<f64>,
    /// Of the heading of the IMU.
    #[modulation(default = 5.0, min = 0.1, max = 1e9)]
    imu_pose_rejection_threshold: Modulation<f64>,
    /// Of a position.
    #[modulation(default = 5.0, min = 0.1, max = 1e9)]
    position_rejection_threshold: Modulation<f64>,
    /// Of a pose.
    #[modulation(default = 5.0, min = 0.1, max = 1e9)]
    pose_rejection_threshold: Modulation<f64>,
}

/// When the velocity or the place is known too badly to drive by it.
#[derive(PortBundle)]
pub(crate) struct Limits {
    /// Greatest standard deviation of the speed ahead with which the odometry is exported.
    #[modulation(default = 0.3, unit = "m/s", min = 0.001, max = 10.0)]
    pub(crate) max_speed_deviation: Modulation<f64>,
    /// Greatest standard deviation of the turn rate with which the odometry is exported.
    #[modulation(default = 0.6, unit = "rad/s", min = 0.001, max = 10.0)]
    pub(crate) max_turn_rate_deviation: Modulation<f64>,
    /// Greatest standard deviation of x or y with which the odometry is exported, if `position` or `pose` is bound.
    #[modulation(default = 2.0, unit = "m", min = 0.001, max = 1000.0)]
    pub(crate) max_position_deviation: Modulation<f64>,
    /// Greatest standard deviation of the heading with which the odometry is exported, if `position` or `pose` is bound.
    #[modulation(default = 20_f64.to_radians(), unit = "rad", min = 0.001, max = 3.15)]
    pub(crate) max_heading_deviation: Modulation<f64>,
}

impl ConstantErrors {
    pub(crate) fn initial(&self, cx: &Context, position: f64, yaw: f64) -> Initial {
        Initial {
            position,
            yaw,
            bias: self.gyro_bias_deviation.get(cx),
            way_scale: self.scale_deviation.get(cx),
            turn_scale: self.turn_scale_deviation.get(cx),
            drift: self.drift_deviation.get(cx),
        }
    }
}

impl ConstantErrors {
    /// The deviations, m and rad, of a pose of this covariance after a step of the wheels.
    pub(crate) fn on_the_way(&self, cx: &Context, covariance: &[[f64; 3]; 3], step: &Pose2D) -> [f64; 2] {
        let way = libm::hypot(step.x, step.y);
        let turned = libm::hypot(
            self.turn_scale_deviation.get(cx) * step.theta,
            self.drift_deviation.get(cx) * way,
        );
        let heading = libm::hypot(covariance[2][2].max(0.0).sqrt(), turned);
        let position = covariance[0][0].max(covariance[1][1]).max(0.0).sqrt();
        let went = libm::hypot(self.scale_deviation.get(cx) * way, heading * way);
        [libm::hypot(position, went), heading]
    }
}

impl Growth {
    pub(crate) fn get(&self, cx: &Context, standstill: f64) -> ProcessNoise {
        ProcessNoise {
            standstill,
            position: self.process_noise_x.get(cx),
            yaw: self.process_noise_yaw.get(cx),
            vx: self.process_noise_vx.get(cx),
            vy: self.process_noise_vy.get(cx),
            rate: self.process_noise_vyaw.get(cx),
            bias: self.process_noise_bias.get(cx),
        }
    }
}

impl Rejection {
    pub(crate) fn get(&self, cx: &Context) -> Thresholds {
        Thresholds {
            turn: self.imu_twist_rejection_threshold.get(cx),
            wheels: self.odom_twist_rejection_threshold.get(cx),
            heading: self.imu_pose_rejection_threshold.get(cx),
            position: self.position_rejection_threshold.get(cx),
            place: self.pose_rejection_threshold.get(cx),
        }
    }
}

/// The covariance of the plane in one of space. A variance that is none has the one of these deviations instead.
pub(crate) fn covariance(space: &[f64; 36], deviations: [f64; 3]) -> [[f64; 3]; 3] {
    let at = [0, 1, 5];
    stated(at.map(|row| at.map(|column| space[6 * row + column])), deviations)
}

/// A covariance as a sensor states it, or the variances of these deviations where it states none.
pub(crate) fn stated<const N: usize>(covariance: [[f64; N]; N], deviations: [f64; N]) -> [[f64; N]; N] {
    let is_stated: [bool; N] =
        core::array::from_fn(|at| covariance[at][at].is_finite() && covariance[at][at] > 0.0);
    core::array::from_fn(|row| {
        core::array::from_fn(
            |column| match (row == column, is_stated[row] && is_stated[column]) {
                (_, true) if covariance[row][column].is_finite() => covariance[row][column],
                (true, _) => deviations[row] * deviations[row],
                (false, _) => 0.0,
            },
        )
    })
}
