//! Point-to-line ICP: a pose from the distances of points to the lines of the surfaces nearest to them.

use jde_types::{Pose2D, normalize_angle};

use crate::matrix::{Matrix, Vector, ZERO, add, add_square, invert, positive, times};
use crate::scan::SurfacePoint;
use crate::surface::{Surface, facing};

/// The most iterations.
const MAX_ITERATIONS: usize = 20;
/// A step that ends it, m and rad.
const CONVERGED_STEP: f64 = 1e-4;
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
    /// The inverse of its covariance, by the points alone. What the noise of normals would say is left out, so it is zero
    /// along a corridor that shows nothing there.
    pub information: Matrix,
    /// The share of the points that are on surfaces.
    pub share: f64,
}

/// The pose with the weight that the points have without the noise of normals: along a corridor that shows nothing there, it is
/// that of the guess (Zhang and Singh, "On degeneracy of optimization-based state estimation problems", 2016). `None` if
/// nothing was known before, or the numbers do not determine it.
fn without_noise(pose: &Pose2D, guess: &Guess, noisy: &Matrix, information: &Matrix) -> Option<Pose2D> {
    if guess.information == ZERO {
        return None;
    }
    let with = |points: &Matrix| {
        let mut both = *points;
        add(&mut both, 1.0, &guess.information);
        both
    };
    let away = [
        pose.x - guess.pose.x,
        pose.y - guess.pose.y,
        normalize_angle(pose.theta - guess.pose.theta),
    ];
    // What the points alone say is farther away than the pose, which is between it and the guess.
    let alone = times(&invert(noisy)?, &times(&with(noisy), &away));
    let [x, y, turn] = times(&invert(&with(information))?, &times(information, &alone));
    Some(Pose2D::new(
        guess.pose.x + x,
        guess.pose.y + y,
        normalize_angle(guess.pose.theta + turn),
    ))
}

/// What points say of a pose.
struct Slopes {
    /// The second and first derivatives of half the squares.
    second: Matrix,
    first: Vector,
    /// How much of the second derivatives may be the noise of normals.
    noise: Matrix,
    /// The share of the points that are within the gate.
    share: f64,
}

impl Surface {
    /// Improves the pose of points, from a pose near it. `None` if the points do not determine it.
    #[must_use]
    pub fn refine(&self, points: &[SurfacePoint], start: &Pose2D, guess: &Guess) -> Option<Fit> {
        let mut pose = *start;
        let mut gate = GATES.0;
        for _ in 0..MAX_ITERATIONS {
            let Slopes {
                second: mut information,
                first: mut slope,
                ..
            } = self.slopes(points, &pose, gate);
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
            if x.abs().max(y.abs()).max(turn.abs()) < CONVERGED_STEP && gate <= GATES.1 {
                break;
            }
            gate = (0.7 * gate).max(GATES.1);
        }
        let slopes = self.slopes(points, &pose, GATES.1);
        let mut information = slopes.second;
        add(&mut information, -1.0, &slopes.noise);
        let information = positive(&information);
        let pose = without_noise(&pose, guess, &slopes.second, &information).unwrap_or(pose);
        pose.is_finite().then_some(Fit {
            pose,
            information,
            share: slopes.share,
        })
    }

    /// Returns the share of points at a pose that are on surfaces.
    #[must_use]
    pub fn share(&self, points: &[SurfacePoint], pose: &Pose2D) -> f64 {
        self.slopes(points, pose, GATES.1).share
    }

    /// What points at a pose say of it.
    ///
    /// A normal that errs by a small angle adds the square of it along the surface. The angle between the normals of a point
    /// and of its line shows how far both err, so its square is at least as much.
    fn slopes(&self, points: &[SurfacePoint], pose: &Pose2D, gate: f64) -> Slopes {
        let (sin, cos) = libm::sincos(pose.theta);
        let (place, turn) = ((pose.x as f32, pose.y as f32), (sin as f32, cos as f32));
        let (mut second, mut first, mut noise) = (ZERO, [0.0; 3], ZERO);
        let (mut near, mut flat) = (0.0, 0.0);
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
            let row = |(x, y): (f64, f64)| [x, y, lever.0 * y - lever.1 * x];
            let across = row(normal);
            for (first, across) in first.iter_mut().zip(across) {
                *first += weight * across * apart;
            }
            add_square(&mut second, weight, &across);
            if point.is_flat() {
                let cosine = f64::from(facing(moved.normal, line.normal));
                let along = row((-normal.1, normal.0));
                add_square(&mut noise, weight * (1.0 - cosine * cosine).max(0.0), &along);
            } else {
                add_square(&mut noise, weight, &across);
            }
        }
        let independent = (INDEPENDENT / f64::max(flat, 1.0)).min(1.0);
        let scale = independent / (DEVIATION * DEVIATION);
        for number in second.iter_mut().chain(&mut noise).flatten().chain(&mut first) {
            *number *= scale;
        }
        Slopes {
            second,
            first,
            noise,
            share: near / points.len().max(1) as f64,
        }
    }
}
