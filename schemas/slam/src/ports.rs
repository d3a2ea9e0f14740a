//! The parameters of simultaneous localization and mapping, by what they are about.

use jde_schema::prelude::*;

/// The file of the map.
#[derive(PortBundle)]
pub(crate) struct MapFile {
    /// The YAML file to which the map is saved, with an image beside it, in the form of a ROS map server. If it is there when
    /// the schema awakes first, its map is continued.
    #[modulation(default = "", unit = "path", fixed, was = "file")]
    pub(crate) map_file_name: Modulation<Text<1024>>,
    /// Time between two savings of a map that changes.
    #[modulation(default = 30.0, unit = "s", min = 1.0, max = 86400.0)]
    pub(crate) save_every: Modulation<f64>,
}

/// How the map is drawn.
#[derive(PortBundle)]
pub(crate) struct Drawing {
    /// Side of a cell of the map. It has at most 4096 × 4096 of them.
    #[modulation(default = 0.05, unit = "m", min = 0.02, max = 1.0, fixed)]
    pub(crate) resolution: Modulation<f64>,
    /// Width of the unknown border around everything that is seen, when the map is drawn anew: targets must be on the
    /// map.
    #[modulation(default = 5.0, unit = "m", min = 0.0, max = 100.0)]
    pub(crate) margin: Modulation<f64>,
    /// Time between two exports of a map that changes.
    #[modulation(default = 1.0, unit = "s", min = 0.05, max = 3600.0, was = "export_every")]
    pub(crate) map_update_interval: Modulation<f64>,
}

/// What counts of a scan.
#[derive(PortBundle)]
pub(crate) struct ScanReading {
    /// Number of beams of a scan that count.
    #[modulation(default = 360, min = 8, max = 1088, fixed, was = "beams")]
    pub(crate) max_beams: Modulation<u32>,
    /// Greatest range of a beam that counts.
    #[modulation(default = 20.0, unit = "m", min = 1.0, max = 100.0, fixed, was = "reach")]
    pub(crate) max_laser_range: Modulation<f64>,
}

/// Which scans are kept.
#[derive(PortBundle)]
pub(crate) struct Keyframes {
    /// The most scans that are kept, as keyframes. Those that are closest to others leave when there are so many.
    #[modulation(default = 4000, min = 2, max = 20_000)]
    pub(crate) keyframes: Modulation<u32>,
    /// Distance from every keyframe at which a scan becomes a keyframe.
    #[modulation(default = 0.5, unit = "m", min = 0.1, max = 3.0)]
    pub(crate) keyframe_way: Modulation<f64>,
    /// Angle from every near keyframe at which a scan becomes a keyframe.
    #[modulation(default = 30_f64.to_radians(), unit = "rad", min = 0.1, max = 3.15)]
    pub(crate) keyframe_turn: Modulation<f64>,
}

/// When a scan is matched, and when it fits.
#[derive(PortBundle)]
pub(crate) struct ScanMatching {
    /// Way after which a scan is matched.
    #[modulation(default = 0.1, unit = "m", min = 0.0, max = 1.0, was = "update_way")]
    pub(crate) minimum_travel_distance: Modulation<f64>,
    /// Turn after which a scan is matched.
    #[modulation(default = 10_f64.to_radians(), unit = "rad", min = 0.0, max = 0.5, was = "update_turn")]
    pub(crate) minimum_travel_heading: Modulation<f64>,
    /// The least share of the points of a scan that are on known surfaces, so that it fits.
    #[modulation(default = 0.4, min = 0.0, max = 1.0, was = "share")]
    pub(crate) match_minimum_response: Modulation<f64>,
}

/// When a place is one that the robot has seen before.
#[derive(PortBundle)]
pub(crate) struct LoopClosure {
    /// How far a keyframe may drift for each metre that the robot goes: how far around it a loop is searched.
    #[modulation(default = 0.05, unit = "m/m", min = 0.0, max = 1.0)]
    pub(crate) drift: Modulation<f64>,
    /// The least share of the points around the robot that are on the surfaces of a place that it reaches again.
    #[modulation(default = 0.55, min = 0.0, max = 1.0, was = "loop_share")]
    pub(crate) loop_match_minimum_response: Modulation<f64>,
    /// Number of matches with the same result that close a loop.
    #[modulation(default = 3, min = 1, max = 8)]
    pub(crate) loop_matches: Modulation<u32>,
}

/// How much the odometry errs.
#[derive(PortBundle)]
pub(crate) struct OdometryNoise {
    /// Standard deviation of the way of the odometry for each metre.
    #[modulation(default = 0.1, unit = "m/m", min = 0.0, max = 10.0, was = "way_by_way")]
    pub(crate) translation_noise_from_translation: Modulation<f64>,
    /// Standard deviation of the heading of the odometry for each radian of a turn.
    #[modulation(default = 0.1, unit = "rad/rad", min = 0.0, max = 10.0, was = "turn_by_turn")]
    pub(crate) rotation_noise_from_rotation: Modulation<f64>,
    /// Standard deviation of the heading of the odometry for each metre of way.
    #[modulation(default = 0.05, unit = "rad/m", min = 0.0, max = 10.0, was = "turn_by_way")]
    pub(crate) rotation_noise_from_translation: Modulation<f64>,
}
