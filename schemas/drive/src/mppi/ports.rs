//! The parameters of the controller, by what they are about.

use jde_mppi::{Shape, Weights};
use jde_schema::prelude::*;

/// The trajectories that are sampled.
#[derive(PortBundle)]
pub(super) struct Sampling {
    /// How many trajectories are sampled.
    #[modulation(default = 2000, min = 8, max = 20_000, fixed, was = "samples")]
    pub(super) batch_size: Modulation<u32>,
    /// How many steps each has.
    #[modulation(default = 56, min = 4, max = 200, fixed, was = "steps")]
    pub(super) time_steps: Modulation<u32>,
    /// Duration of a step.
    #[modulation(default = 0.05, unit = "s", min = 0.01, max = 0.2, fixed, was = "step")]
    pub(super) model_dt: Modulation<f64>,
    /// Standard deviation of the sampled commands, as a share of the greatest ones.
    #[modulation(default = 0.6, min = 0.01, max = 2.0)]
    pub(super) spread: Modulation<f64>,
    /// Difference of costs at which a trajectory counts 1/e of another.
    #[modulation(default = 0.1, min = 0.001)]
    pub(super) temperature: Modulation<f64>,
}

/// What makes a trajectory cost more.
#[derive(PortBundle)]
pub(super) struct Critics {
    /// Cost of a metre of distance to the path.
    #[modulation(default = 2.0, min = 0.0, was = "path_weight")]
    pub(super) path_align_weight: Modulation<f64>,
    /// Cost of each metre by which it stays behind a drive along the path at full speed.
    #[modulation(default = 15.0, min = 0.0, was = "progress_weight")]
    pub(super) path_follow_weight: Modulation<f64>,
    /// Cost of an error of the heading of 1 rad, if the path is not ahead.
    #[modulation(default = 3.0, min = 0.0, was = "heading_weight")]
    pub(super) path_angle_weight: Modulation<f64>,
    /// Cost of a trajectory along obstacles that it nearly touches; half of `inflation_radius` away costs a quarter.
    #[modulation(default = 4.0, min = 0.0, was = "obstacle_weight")]
    pub(super) obstacles_weight: Modulation<f64>,
    /// Cost of each m/s backward or to a side.
    #[modulation(default = 5.0, min = 0.0, was = "forward_weight")]
    pub(super) prefer_forward_weight: Modulation<f64>,
    /// Cost of a turn rate of 1 rad/s; it grows with the square.
    #[modulation(default = 0.3, min = 0.0, was = "effort_weight")]
    pub(super) twirling_weight: Modulation<f64>,
}

/// What is around the robot.
#[derive(PortBundle)]
pub(super) struct Obstacles {
    /// Distance to keep from obstacles.
    #[modulation(default = 0.05, unit = "m", min = 0.0, margin)]
    pub(super) margin: Modulation<f64>,
    /// Clearance below which a trajectory costs more.
    #[modulation(default = 0.4, unit = "m", min = 0.0, was = "near")]
    pub(super) inflation_radius: Modulation<f64>,
    /// How far obstacles count.
    #[modulation(default = 2.5, unit = "m", min = 0.5, max = 5.0, fixed)]
    pub(super) reach: Modulation<f64>,
    /// How long an obstacle counts that is out of sight.
    #[modulation(default = 10.0, unit = "s", min = 0.0, was = "memory")]
    pub(super) observation_persistence: Modulation<f64>,
}

/// How a base that is not differential, or that drives backward, may move.
#[derive(PortBundle)]
pub(super) struct Kinematics {
    /// Greatest speed backward. Behind a laser that looks ahead, only obstacles that it saw before are known.
    #[modulation(default = 0.0, unit = "m/s", min = 0.0, limit)]
    pub(super) reverse: Modulation<f64>,
    /// Greatest speed to each side, of an omnidirectional base.
    #[modulation(default = 0.0, unit = "m/s", min = 0.0, was = "sideways")]
    pub(super) vy_max: Modulation<f64>,
    /// Least turning radius, of a car; 0 for a base that turns on the spot.
    #[modulation(default = 0.0, unit = "m", min = 0.0, was = "turning_radius")]
    pub(super) min_turning_r: Modulation<f64>,
}

impl Sampling {
    pub(super) fn shape(&self, cx: &Context) -> Shape {
        Shape {
            samples: self.batch_size.get(cx) as usize,
            steps: self.time_steps.get(cx) as usize,
            step: self.model_dt.get(cx) as f32,
        }
    }
}

impl Critics {
    pub(super) fn weights(&self, cx: &Context) -> Weights {
        Weights {
            path: self.path_align_weight.get(cx) as f32,
            progress: self.path_follow_weight.get(cx) as f32,
            heading: self.path_angle_weight.get(cx) as f32,
            obstacle: self.obstacles_weight.get(cx) as f32,
            forward: self.prefer_forward_weight.get(cx) as f32,
            effort: self.twirling_weight.get(cx) as f32,
        }
    }
}
