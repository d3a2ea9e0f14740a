//! The odometry motion model ("Probabilistic Robotics", table 5.6): a turn, a way and another turn, each with an error.
//!
//! The first turn is here toward the direction of the way, whichever way the base faces, so that the model fits bases
//! that drive backward or sideways. The errors of the two turns are those of the heading, one half each.

use jde_types::Pose2D;

use crate::random::normals;

/// Standard deviations of the odometry, which grow with the motion. Two that have the same unit add as squares.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MotionNoise {
    /// Of the heading, for each radian of a turn, rad/rad.
    pub turn_by_turn: f64,
    /// Of the heading, for each metre of way, rad/m.
    pub turn_by_way: f64,
    /// Of the way, for each metre, m/m.
    pub way_by_way: f64,
    /// Of the way, for each radian of a turn, m/rad.
    pub way_by_turn: f64,
}

/// Suits wheels on a floor of an office.
impl Default for MotionNoise {
    fn default() -> Self {
        Self {
            turn_by_turn: 0.1,
            turn_by_way: 0.05,
            way_by_way: 0.1,
            way_by_turn: 0.02,
        }
    }
}

/// A motion of the base, as the odometry measured it, and its errors. The unit of length is that of the caller.
#[derive(Clone, Copy, Debug)]
pub(crate) struct OdometryMotion {
    direction: f32,
    way: f32,
    turn: f32,
    way_deviation: f32,
    /// Of each of the two turns.
    turn_deviation: f32,
}

impl MotionNoise {
    /// The motion `delta` in the frame of the base before it, in metres, with lengths in cells of `cell` m.
    pub(crate) fn motion(&self, delta: &Pose2D, cell: f64) -> OdometryMotion {
        let (way, turn) = (libm::hypot(delta.x, delta.y), delta.theta.abs());
        let heading = libm::hypot(self.turn_by_turn * turn, self.turn_by_way * way);
        OdometryMotion {
            direction: libm::atan2(delta.y, delta.x) as f32,
            way: (way / cell) as f32,
            turn: delta.theta as f32,
            way_deviation: (libm::hypot(self.way_by_way * way, self.way_by_turn * turn) / cell) as f32,
            turn_deviation: (heading * core::f64::consts::FRAC_1_SQRT_2) as f32,
        }
    }
}

impl OdometryMotion {
    /// Returns a sample of the pose after the motion.
    pub(crate) fn sample(&self, [x, y, heading]: [f32; 3], random: &mut fastrand::Rng) -> [f32; 3] {
        let ([first, second], [along, _]) = (normals(random), normals(random));
        let turned = heading + self.turn_deviation * first;
        let way = self.way + self.way_deviation * along;
        let (sin, cos) = libm::sincosf(turned + self.direction);
        let heading = turned + self.turn + self.turn_deviation * second;
        [x + way * cos, y + way * sin, heading]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const NOISE: MotionNoise = MotionNoise {
        turn_by_turn: 0.1,
        turn_by_way: 0.08,
        way_by_way: 0.05,
        way_by_turn: 0.03,
    };

    /// Means and standard deviations of x, y and the heading.
    fn moments(samples: impl Iterator<Item = [f64; 3]>) -> [[f64; 3]; 2] {
        let (mut count, mut sums, mut squares) = (0.0, [0.0; 3], [0.0; 3]);
        for sample in samples {
            count += 1.0;
            for part in 0..3 {
                sums[part] += sample[part];
                squares[part] += sample[part] * sample[part];
            }
        }
        let means = sums.map(|sum| sum / count);
        [
            means,
            core::array::from_fn(|part| (squares[part] / count - means[part] * means[part]).sqrt()),
        ]
    }

    /// Table 5.6 of the book, whose turns come before and after the way. A turn error is a sum of twelve uniform
    /// numbers here.
    fn of_the_book(delta: &Pose2D, random: &mut fastrand::Rng) -> [f64; 3] {
        let mut noise = |deviation: f64| deviation * ((0..12).map(|_| random.f64()).sum::<f64>() - 6.0);
        let way = delta.x.hypot(delta.y);
        let first = if way > 0.0 { delta.y.atan2(delta.x) } else { 0.0 };
        let second = delta.theta - first;
        let turn = ((NOISE.turn_by_turn * delta.theta).powi(2) + (NOISE.turn_by_way * way).powi(2)).sqrt();
        let along = ((NOISE.way_by_way * way).powi(2) + (NOISE.way_by_turn * delta.theta).powi(2)).sqrt();
        let first = first + noise(turn / 2_f64.sqrt());
        let way = way + noise(along);
        let second = second + noise(turn / 2_f64.sqrt());
        [way * first.cos(), way * first.sin(), first + second]
    }

    #[test]
    fn its_moments_are_those_of_the_books_model() {
        for delta in [
            Pose2D::new(0.5, 0.0, 0.0),
            Pose2D::new(0.4, 0.1, 0.5),
            Pose2D::new(-0.5, 0.05, -0.2),
            Pose2D::new(0.0, 0.5, 0.1),
            Pose2D::new(0.0, 0.0, 1.0),
        ] {
            let mut random = fastrand::Rng::with_seed(1);
            let motion = NOISE.motion(&delta, 0.05);
            let found = moments((0..40_000).map(|_| {
                let [x, y, heading] = motion.sample([0.0; 3], &mut random);
                [f64::from(x) * 0.05, f64::from(y) * 0.05, heading.into()]
            }));
            let expected = moments((0..40_000).map(|_| of_the_book(&delta, &mut random)));
            for (found, expected) in found.iter().zip(&expected) {
                for (found, expected) in found.iter().zip(expected) {
                    // Five standard errors of a mean of 40 000 samples, each of at most 0.1.
                    assert!(
                        (found - expected).abs() < 0.0025,
                        "{delta:?}: {found} for {expected}"
                    );
                }
            }
        }
    }

    #[test]
    fn without_a_motion_nothing_moves() {
        let motion = NOISE.motion(&Pose2D::ORIGIN, 0.05);
        let pose = [3.0, 4.0, 0.5];
        assert_eq!(motion.sample(pose, &mut fastrand::Rng::with_seed(1)), pose);
    }
}
