//! The path that a robot has driven, by its odometry. It is bounded: a long path is thinned to every second
//! point. It draws nothing.

/// Nearer points are merged, in m.
const MERGE_DISTANCE: f64 = 0.03;
/// A larger step starts a new path, in m: the robot was moved, or values were lost.
const NEW_PATH_DISTANCE: f64 = 1.0;
/// Maximum number of points: a path of at least 300 m before it is thinned.
const MAX_POINTS: usize = 10_000;

/// The paths that a robot has driven.
#[derive(Clone, Debug, Default)]
pub(crate) struct Trail {
    of: String,
    points: Vec<TrailPoint>,
    last: u64,
}

#[derive(Clone, Copy, Debug)]
struct TrailPoint {
    at: [f64; 2],
    /// A path begins here: the robot was moved, or values were lost.
    begins: bool,
}

impl Trail {
    /// Sets the odometry variable. Another one than before clears the trail.
    pub(crate) fn of(&mut self, variable: &str) {
        if self.of != variable {
            *self = Self {
                of: variable.to_owned(),
                ..Self::default()
            };
        }
    }

    /// Adds a position, in m, at a time in ns. Positions that are not finite are ignored.
    pub(crate) fn add(&mut self, time: u64, at: [f64; 2]) {
        if !at.iter().all(|coordinate| coordinate.is_finite()) {
            return;
        }
        if time < self.last {
            // A recording jumped back: the trail lies in the future.
            self.points.clear();
        }
        self.last = time;
        let distance = self
            .points
            .last()
            .map(|before| (at[0] - before.at[0]).hypot(at[1] - before.at[1]));
        if distance.is_some_and(|distance| distance < MERGE_DISTANCE) {
            return;
        }
        if self.points.len() == MAX_POINTS {
            self.thin();
        }
        let begins = distance.is_none_or(|distance| distance > NEW_PATH_DISTANCE);
        self.points.push(TrailPoint { at, begins });
    }

    /// The paths, oldest first, each with its points in m.
    pub(crate) fn paths(&self) -> impl Iterator<Item = impl ExactSizeIterator<Item = [f64; 2]> + '_> {
        self.points
            .chunk_by(|_, next| !next.begins)
            .map(|path| path.iter().map(|place| place.at))
    }

    fn thin(&mut self) {
        let mut number = 0_usize;
        self.points.retain(|place| {
            number += 1;
            number % 2 == 1 || place.begins
        });
        // A trail that consists of jumps cannot be thinned: the oldest points are removed.
        let surplus = self.points.len().saturating_sub(MAX_POINTS / 4 * 3);
        self.points.drain(..surplus);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn paths(trail: &Trail) -> Vec<Vec<[f64; 2]>> {
        trail.paths().map(Iterator::collect).collect()
    }

    #[test]
    fn a_standing_robot_adds_one_point_and_a_driving_one_a_bounded_path() {
        let mut trail = Trail::default();
        for time in 0..100 {
            trail.add(time, [1.0, 0.001 * (time % 2) as f64]);
        }
        assert_eq!(paths(&trail), [[[1.0, 0.0]]]);
        for step in 0..100_000_u64 {
            trail.add(100 + step, [1.0 + 0.5 * step as f64, 0.0]);
        }
        let path = &paths(&trail)[0];
        assert!(
            path.len() <= MAX_POINTS && path.len() > MAX_POINTS / 4,
            "{}",
            path.len()
        );
        assert_eq!((path[0], path[path.len() - 1]), ([1.0, 0.0], [50_000.5, 0.0]));
    }

    #[test]
    fn a_robot_that_is_moved_by_hand_starts_a_new_path() {
        let mut trail = Trail::default();
        for (time, at) in [[0.0, 0.0], [0.5, 0.0], [f64::NAN, 0.0], [9.0, 9.0], [9.5, 9.0]]
            .into_iter()
            .enumerate()
        {
            trail.add(time as u64, at);
        }
        assert_eq!(
            paths(&trail),
            [[[0.0, 0.0], [0.5, 0.0]], [[9.0, 9.0], [9.5, 9.0]]]
        );
        for step in 0..100_000_u64 {
            trail.add(9 + step, [10.0 * step as f64, 0.0]);
        }
        assert!(
            paths(&trail).len() <= MAX_POINTS,
            "a trail of jumps is bounded too"
        );
    }

    #[test]
    fn a_jump_back_in_time_and_another_robot_clear_the_trail() {
        let mut trail = Trail::default();
        trail.of("one.odometry");
        trail.add(5, [1.0, 0.0]);
        trail.add(4, [2.0, 0.0]);
        assert_eq!(paths(&trail), [[[2.0, 0.0]]]);
        trail.of("other.odometry");
        assert!(paths(&trail).is_empty());
    }
}
