//! The parameters of adaptive Monte Carlo localization, by what they are about.

use jde_schema::prelude::*;
use jde_schema::types::Start;

/// How likely a scan is at a pose.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Choice)]
#[repr(u8)]
pub(super) enum SensorModel {
    /// By the distance from the end of each beam to the nearest obstacle.
    LikelihoodField,
    /// By the difference of the length of each beam from that of a ray through the map. Some thirty times slower.
    Beam,
}

/// Where the robot is at first.
#[derive(PortBundle)]
pub(super) struct InitialPose {
    /// Where the robot is when the schema awakes first and whenever this is written, in the frame of the map:
    /// `[[3.55, 1.6, "90 deg"]]`. Without a pose it is searched.
    #[modulation(default = Start::NONE, was = "initial")]
    pub(super) initial_pose: Modulation<Start>,
    /// Standard deviation of x and y of that pose.
    #[modulation(default = 0.3, unit = "m", min = 0.0, max = 10.0)]
    pub(super) initial_deviation: Modulation<f64>,
    /// Standard deviation of the heading of that pose.
    #[modulation(default = 15_f64.to_radians(), unit = "rad", min = 0.0, max = 3.15)]
    pub(super) initial_heading_deviation: Modulation<f64>,
}

/// How many particles there are: KLD-sampling.
#[derive(PortBundle)]
pub(super) struct Particles {
    /// The most particles.
    #[modulation(default = 2000, min = 10, max = 100_000, fixed, was = "particles")]
    pub(super) max_particles: Modulation<u32>,
    /// The fewest particles.
    #[modulation(default = 500, min = 2, max = 100_000, was = "least")]
    pub(super) min_particles: Modulation<u32>,
    /// The error of KLD-sampling: a smaller one needs more particles.
    #[modulation(default = 0.05, min = 0.001, max = 1.0, was = "error")]
    pub(super) kld_err: Modulation<f64>,
    /// The quantile of the standard normal distribution for the probability of that error: 2.326 for 99 %.
    #[modulation(default = 2.326, min = 0.0, max = 5.0, was = "quantile")]
    pub(super) kld_z: Modulation<f64>,
}

/// How much the odometry errs.
#[derive(PortBundle)]
pub(super) struct OdometryNoise {
    /// Standard deviation of the heading of the odometry for each radian of a turn.
    #[modulation(default = 0.1, unit = "rad/rad", min = 0.0, max = 10.0, was = "turn_by_turn")]
    pub(super) rotation_noise_from_rotation: Modulation<f64>,
    /// Standard deviation of the heading of the odometry for each metre of way.
    #[modulation(default = 0.05, unit = "rad/m", min = 0.0, max = 10.0, was = "turn_by_way")]
    pub(super) rotation_noise_from_translation: Modulation<f64>,
    /// Standard deviation of the way of the odometry for each metre.
    #[modulation(default = 0.1, unit = "m/m", min = 0.0, max = 10.0, was = "way_by_way")]
    pub(super) translation_noise_from_translation: Modulation<f64>,
    /// Standard deviation of the way of the odometry for each radian of a turn.
    #[modulation(default = 0.02, unit = "m/rad", min = 0.0, max = 10.0, was = "way_by_turn")]
    pub(super) translation_noise_from_rotation: Modulation<f64>,
}

/// How well a scan fits a pose.
#[derive(PortBundle)]
pub(super) struct SensorNoise {
    /// How likely a scan is at a pose: `likelihood-field` or `beam`.
    #[modulation(default = SensorModel::LikelihoodField, was = "model")]
    pub(super) laser_model_type: Modulation<SensorModel>,
    /// How many beams of a scan count.
    #[modulation(default = 60, min = 8, max = 1088, fixed, was = "beams")]
    pub(super) max_beams: Modulation<u32>,
    /// Standard deviation of the ends of beams from the obstacles of the map: that of the laser and of the map.
    #[modulation(default = 0.1, unit = "m", min = 0.01, max = 2.0, was = "deviation")]
    pub(super) sigma_hit: Modulation<f64>,
    /// Likelihood of a beam that hits something that is not on the map, where a beam that fits exactly has about 1.
    #[modulation(default = 0.1, min = 0.0001, max = 0.9, was = "outliers")]
    pub(super) z_rand: Modulation<f64>,
    /// Number of independent measurements for which a scan counts, since the errors of neighbouring beams are alike.
    #[modulation(default = 20.0, min = 1.0, max = 1088.0)]
    pub(super) independent: Modulation<f64>,
}

/// When the particles are weighed.
#[derive(PortBundle)]
pub(super) struct Updates {
    /// Way after which the particles are weighed.
    #[modulation(default = 0.1, unit = "m", min = 0.0, max = 10.0, was = "update_way")]
    pub(super) update_min_d: Modulation<f64>,
    /// Turn after which the particles are weighed.
    #[modulation(default = 0.1, unit = "rad", min = 0.0, max = 3.15, was = "update_turn")]
    pub(super) update_min_a: Modulation<f64>,
}

/// How a lost robot is searched.
#[derive(PortBundle)]
pub(super) struct Search {
    /// The most poses at which a lost robot is searched.
    #[modulation(default = 2_000_000, min = 1000, max = 100_000_000)]
    pub(super) search: Modulation<u32>,
    /// Number of poses at which the robot is searched for in each iteration.
    #[modulation(default = 40_000, min = 1000, max = 10_000_000)]
    pub(super) search_step: Modulation<u32>,
    /// Way that a robot must go until its pose is sure, after a search that found several places, looked around a click
    /// only, or had too few poses for the map.
    #[modulation(default = 1.0, unit = "m", min = 0.0, max = 100.0)]
    pub(super) confirm: Modulation<f64>,
}

/// How well a scan must agree with the map.
#[derive(PortBundle)]
pub(super) struct Agreement {
    /// Least share of the beams that agree with the map, as an average over scans, when the pose becomes sure.
    #[modulation(default = 0.7, min = 0.0, max = 1.0)]
    pub(super) sure_agreement: Modulation<f64>,
    /// The same while the pose is sure.
    #[modulation(default = 0.5, min = 0.0, max = 1.0)]
    pub(super) agreement: Modulation<f64>,
    /// The same while a search of the whole map finds no place that explains the scan better: the map has changed. A pose
    /// that was never sure does not become so by it.
    #[modulation(default = 0.3, min = 0.0, max = 1.0)]
    pub(super) changed_agreement: Modulation<f64>,
    /// How far the end of a beam that agrees may be from an obstacle of the map.
    #[modulation(default = 0.25, unit = "m", min = 0.0, max = 1.0)]
    pub(super) tolerance: Modulation<f64>,
    /// Least share of the particles' weights that is at one place when the pose is sure.
    #[modulation(default = 0.95, min = 0.5, max = 1.0)]
    pub(super) share: Modulation<f64>,
}
