//! Point-to-line ICP: a pose from the distances of points to the lines of the surfaces nearest to them.

use jde_types::{Pose2D, normalize_angle};

use crate::matrix::{Matrix, ZERO, add, invert, times};
use crate::scan::SurfacePoint;
use crate::surface::{Surface, facing};

/// The most iterations.
const MOST: usize = 20;
/// A step that ends it, m and rad.
const SMALL: f64 = 1e-4;
/// How far points may be from their lines at first, and how far at last, m.
const GATES: (f64, f64) = (0.3, 0.1);
/// The standard deviation of points from lines, m.
const DEVIATION: f64 = 0.03;
/// How many points of a scan are independent measurements. Neighbours err alike.
const INDEPENDENT: f64 = 40.0;

/// What is known of a pose before the match.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Guess {
    /// The pose.
    pub pose: Pose2D,
    /// The inverse of its covariance; zero if nothing is known.
    pub information: Matrix,
}

/// A pose that fits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fit {
    /// The pose.
    pub pose: Pose2D,
    /// The inverse of its covariance, by the points alone.
    pub information: Matrix,
    /// The share of the points that are on surfaces.
    pub share: f64,
}

impl Surface {
    /// Improves the pose of points, from a pose near it. `None` if the points do not determine it.
    #[must_use]
    pub fn refine(&self, points: &[SurfacePoint], start: &Pose2D, guess: &Guess) -> Option<Fit> {
        let mut pose = *start;
        let mut gate = GATES.0;
        for _ in 0..MOST {
            let (mut information, mut slope, _) = self.slope(points, &pose, gate);
            add(&mut information, 1.0, &guess.information);
            let away = [
                pose.x - guess.pose.x,
                pose.y - guess.pose.y,
                normalize_angle(pose.theta - guess.pose.theta),
            ];
            let pull = times(&guess.information, &away);
            (0..3).for_each(|axis| slope[axis] += pull[axis]);
            let [x, y, turn] = times(&invert(&information)?, &slope);
            pose = Pose2D::new(pose.x - x, pose.y - y, normalize_angle(pose.theta - turn));
            if x.abs().max(y.abs()).max(turn.abs()) < SMALL && gate <= GATES.1 {
                break;
            }
            gate = (0.7 * gate).max(GATES.1);
        }
        let (information, _, share) = self.slope(points, &pose, GATES.1);
        pose.is_finite().then_some(Fit {
            pose,
            information,
            share,
        })
    }

    /// Returns the share of points at a pose that are on surfaces.
    #[must_use]
    pub fn share(&self, points: &[SurfacePoint], pose: &Pose2D) -> f64 {
        self.slope(points, pose, GATES.1).2
    }

    /// The second and first derivatives of half the squares, and the share of the points that are within the gate.
    fn slope(&self, points: &[SurfacePoint], pose: &Pose2D, gate: f64) -> (Matrix, [f64; 3], f64) {
        let (sin, cos) = libm::sincos(pose.theta);
        let (place, turn) = ((pose.x as f32, pose.y as f32), (sin as f32, cos as f32));
        let (mut second, mut first, mut near, mut flat) = (ZERO, [0.0; 3], 0.0, 0.0);
        for point in points {
            let moved = point.moved(place, turn);
            let Some(line) = self.nearest(moved.at) else {
                continue;
            };
            let apart = (moved.at.0 - line.at.0, moved.at.1 - line.at.1);
            let away = f64::from(libm::hypotf(apart.0, apart.1));
            if away < gate.max(0.15) {
                near += 1.0;
            }
            let is_back = point.is_flat() && facing(moved.normal, line.normal) < 0.5;
            if !line.is_flat() || is_back {
                continue;
            }
            let apart = f64::from(facing(apart, line.normal));
            if apart.abs() > gate {
                continue;
            }
            flat += 1.0;
            let share = apart / gate;
            let weight = (1.0 - share * share) * (1.0 - share * share);
            let normal = (f64::from(line.normal.0), f64::from(line.normal.1));
            let lever = (f64::from(moved.at.0) - pose.x, f64::from(moved.at.1) - pose.y);
            let row = [normal.0, normal.1, lever.0 * normal.1 - lever.1 * normal.0];
            for (number, at) in row.iter().enumerate() {
                first[number] += weight * at * apart;
                for (sum, other) in second[number].iter_mut().zip(row) {
                    *sum += weight * at * other;
                }
            }
        }
        let independent = (INDEPENDENT / f64::max(flat, 1.0)).min(1.0);
        let scale = independent / (DEVIATION * DEVIATION);
        second.iter_mut().flatten().for_each(|number| *number *= scale);
        first.iter_mut().for_each(|number| *number *= scale);
        (second, first, near / points.len().max(1) as f64)
    }
}
