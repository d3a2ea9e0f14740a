//! How it maps, and what follows for a motion by the odometry.

use jde_types::Pose2D;

use crate::correlation::Window;
use crate::icp::Guess;
use crate::matrix::{Matrix, diagonal};

/// The most squares that the correlation of successive scans looks at.
const MAX_SEARCHED_CELLS: usize = 20_000;

/// How it maps. All may change from call to call.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Motion after which a scan is matched, m and rad.
    pub update: (f64, f64),
    /// How far from every keyframe a scan becomes one, m and rad.
    pub keyframe: (f64, f64),
    /// The most keyframes.
    pub most: usize,
    /// The standard deviation of the way of the odometry for each metre, m/m.
    pub way_by_way: f64,
    /// That of the heading for each radian, rad/rad.
    pub turn_by_turn: f64,
    /// That of the heading for each metre, rad/m.
    pub turn_by_way: f64,
    /// The least share of the points of a scan that are on known surfaces.
    pub share: f64,
    /// How far the pose of a keyframe may drift for each metre along the graph, m/m: how far loops are searched.
    pub drift: f64,
    /// The least share of the points around the robot that are on the surfaces of a place that is reached again.
    pub loop_share: f64,
    /// How many matches that say the same close a loop.
    pub loop_matches: usize,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            update: (0.1, 10_f64.to_radians()),
            keyframe: (0.5, 30_f64.to_radians()),
            most: 4000,
            way_by_way: 0.1,
            turn_by_turn: 0.1,
            turn_by_way: 0.05,
            share: 0.4,
            drift: 0.05,
            loop_share: 0.55,
            loop_matches: 3,
        }
    }
}

impl Settings {
    /// The inverse of the covariance of a motion by the odometry.
    pub(super) fn information(&self, motion: &Pose2D) -> Matrix {
        diagonal(
            self.deviations(motion)
                .map(|deviation| 1.0 / (deviation * deviation)),
        )
    }

    /// The standard deviations of a motion by the odometry: x, y, heading.
    pub(super) fn deviations(&self, motion: &Pose2D) -> [f64; 3] {
        let (way, turn) = (libm::hypot(motion.x, motion.y), motion.theta.abs());
        let position = 0.01 + self.way_by_way * way;
        let heading = 0.005 + self.turn_by_turn * turn + self.turn_by_way * way;
        [position, position, heading]
    }

    /// Three standard deviations around what the odometry says.
    pub(super) fn window(&self, guess: &Guess) -> Window {
        let deviation = |axis: usize| 1.0 / libm::sqrt(guess.information[axis][axis]);
        Window {
            way: (3.0 * deviation(0)).clamp(0.1, 0.6),
            turn: (3.0 * deviation(2)).clamp(0.05, 0.8),
            least: 0.2,
            loss: 0.1,
            most: MAX_SEARCHED_CELLS,
        }
    }
}
