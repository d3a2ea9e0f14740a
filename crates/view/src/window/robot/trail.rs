//! The path that the robot has driven, as its odometry tells. Bounded: of a long one every other point is kept.

/// Nearer places count as one, m.
const STEP: f64 = 0.02;
/// Points kept at most.
const MOST: usize = 8000;

/// Where a robot has been.
#[derive(Clone, Debug, Default)]
pub(super) struct Trail {
    of: String,
    points: Vec<[f64; 2]>,
    last: u64,
}

impl Trail {
    /// Begins anew if this is another variable than before.
    pub(super) fn of(&mut self, variable: &str) {
        if self.of != variable {
            *self = Self {
                of: variable.to_owned(),
                ..Self::default()
            };
        }
    }

    /// It was here at this time, ns.
    pub(super) fn add(&mut self, time: u64, place: [f64; 2]) {
        if time < self.last {
            // A recording went back.
            self.points.clear();
        }
        self.last = time;
        let moved = |last: &[f64; 2]| (place[0] - last[0]).hypot(place[1] - last[1]) >= STEP;
        if self.points.last().is_none_or(moved) {
            if self.points.len() == MOST {
                let mut every_other = false;
                self.points.retain(|_| {
                    every_other = !every_other;
                    every_other
                });
            }
            self.points.push(place);
        }
    }

    /// Places, oldest first, m.
    pub(super) fn points(&self) -> &[[f64; 2]] {
        &self.points
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_robot_that_stands_leaves_one_point_and_one_that_drives_a_path_of_bounded_length() {
        let mut trail = Trail::default();
        trail.of("pioneer.odometry");
        for time in 0..100 {
            trail.add(time, [1.0, 0.001 * (time % 2) as f64]);
        }
        assert_eq!(trail.points(), [[1.0, 0.0]]);
        for step in 0..100_000_u64 {
            trail.add(100 + step, [step as f64, 0.0]);
        }
        assert!(trail.points().len() <= MOST && trail.points().len() > MOST / 2);
        assert_eq!(trail.points().last(), Some(&[99_999.0, 0.0]));
    }

    #[test]
    fn a_recording_that_goes_back_and_another_robot_begin_anew() {
        let mut trail = Trail::default();
        trail.of("one.odometry");
        trail.add(5, [1.0, 0.0]);
        trail.add(4, [2.0, 0.0]);
        assert_eq!(trail.points(), [[2.0, 0.0]]);
        trail.of("other.odometry");
        assert!(trail.points().is_empty());
    }
}
