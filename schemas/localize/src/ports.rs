//! The ports that both localizers have.

use jde_schema::prelude::*;

/// How sure a pose must be, and how far the odometry may jump.
#[derive(PortBundle)]
pub(crate) struct PoseLimits {
    /// Greatest standard deviation of a position that is sure.
    #[modulation(default = 0.3, unit = "m", min = 0.0, max = 10.0)]
    pub(crate) sure_deviation: Modulation<f64>,
    /// Greatest standard deviation of a heading that is sure.
    #[modulation(default = 0.2, unit = "rad", min = 0.0, max = 3.15)]
    pub(crate) sure_heading_deviation: Modulation<f64>,
    /// Least step of the odometry that is a jump and no motion. A turn by more than 90 degrees is a jump too.
    #[modulation(default = 1.0, unit = "m", min = 0.3)]
    pub(crate) jump: Modulation<f64>,
}

/// Where the robot is, and how sure that is.
#[derive(PortBundle)]
pub(crate) struct LocalizedPose {
    /// The pose in the frame of the map with its covariance, and the velocity of the odometry.
    #[export]
    pub(crate) pose: Export<Odometry>,
    /// The pose of the odometry's frame in that of the map (REP-105), while the pose is sure.
    #[export]
    pub(crate) correction: Export<PoseStamped>,
    /// How sure the pose is, in words.
    #[export]
    pub(crate) state: Export<Text<160>>,
}
