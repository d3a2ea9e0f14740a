//! The path that a robot has driven, as its odometry tells. Bounded: of a long one every other place is kept. It draws nothing.

/// Nearer places count as one, m.
const STEP: f64 = 0.03;
/// A robot that is elsewhere all at once did not drive there as far as anybody knows, m.
const JUMP: f64 = 1.0;
/// Places kept at most: 300 m at the least.
const MOST: usize = 10_000;

/// Where a robot has been.
#[derive(Clone, Debug, Default)]
pub(crate) struct Trail {
    of: String,
    places: Vec<TrailPoint>,
    last: u64,
}

#[derive(Clone, Copy, Debug)]
struct TrailPoint {
    at: [f64; 2],
    /// A path begins here: the robot was put here, or nobody looked for a while.
    begins: bool,
}

impl Trail {
    /// Begins anew if this is another variable than before.
    pub(crate) fn of(&mut self, variable: &str) {
        if self.of != variable {
            *self = Self {
                of: variable.to_owned(),
                ..Self::default()
            };
        }
    }

    /// It was here at this time, ns.
    pub(crate) fn add(&mut self, time: u64, at: [f64; 2]) {
        if !at.iter().all(|part| part.is_finite()) {
            return;
        }
        if time < self.last {
            // A recording went back: that has not happened yet.
            self.places.clear();
        }
        self.last = time;
        let moved = self
            .places
            .last()
            .map(|before| (at[0] - before.at[0]).hypot(at[1] - before.at[1]));
        if moved.is_some_and(|moved| moved < STEP) {
            return;
        }
        if self.places.len() == MOST {
            self.thin();
        }
        let begins = moved.is_none_or(|moved| moved > JUMP);
        self.places.push(TrailPoint { at, begins });
    }

    /// The paths, oldest first, each from place to place, m.
    pub(crate) fn paths(&self) -> impl Iterator<Item = impl ExactSizeIterator<Item = [f64; 2]> + '_> {
        self.places
            .chunk_by(|_, next| !next.begins)
            .map(|path| path.iter().map(|place| place.at))
    }

    fn thin(&mut self) {
        let mut number = 0_usize;
        self.places.retain(|place| {
            number += 1;
            number % 2 == 1 || place.begins
        });
        // One that jumps all the time has no path to be thinned.
        let surplus = self.places.len().saturating_sub(MOST / 4 * 3);
        self.places.drain(..surplus);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn paths(trail: &Trail) -> Vec<Vec<[f64; 2]>> {
        trail.paths().map(Iterator::collect).collect()
    }

    #[test]
    fn a_robot_that_stands_leaves_one_place_and_one_that_drives_a_path_of_bounded_length() {
        let mut trail = Trail::default();
        for time in 0..100 {
            trail.add(time, [1.0, 0.001 * (time % 2) as f64]);
        }
        assert_eq!(paths(&trail), [[[1.0, 0.0]]]);
        for step in 0..100_000_u64 {
            trail.add(100 + step, [1.0 + 0.5 * step as f64, 0.0]);
        }
        let path = &paths(&trail)[0];
        assert!(path.len() <= MOST && path.len() > MOST / 4, "{}", path.len());
        assert_eq!((path[0], path[path.len() - 1]), ([1.0, 0.0], [50_000.5, 0.0]));
    }

    #[test]
    fn a_robot_that_is_put_elsewhere_did_not_drive_there() {
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
        assert!(paths(&trail).len() <= MOST, "bounded, whatever it does");
    }

    #[test]
    fn a_recording_that_goes_back_and_another_robot_begin_anew() {
        let mut trail = Trail::default();
        trail.of("one.odometry");
        trail.add(5, [1.0, 0.0]);
        trail.add(4, [2.0, 0.0]);
        assert_eq!(paths(&trail), [[[2.0, 0.0]]]);
        trail.of("other.odometry");
        assert!(paths(&trail).is_empty());
    }
}
