//! Correlative scan matching: where most points of a scan are on surfaces, of all poses in a window.
//!
//! Branch and bound finds the best pose without a look at all others: the maxima of squares of the grid bound the score of
//! all poses whose points lie in these squares.

use core::cmp::Ordering;
use std::collections::BinaryHeap;

use jde_types::{Pose2D, normalize_angle};

use crate::scan::SurfacePoint;
use crate::surface::{CELL, Surface};

/// Where a match is searched.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Window {
    /// How far from the middle in x and in y, m.
    pub way: f64,
    /// How far the heading is turned, rad.
    pub turn: f64,
    /// The least score that counts, from 0 to 1.
    pub least: f64,
    /// How much a pose at the edge of the window loses, in x, in y, and in heading.
    pub loss: f64,
    /// How many squares are looked at: the most work of a call.
    pub most: usize,
}

/// A pose that fits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Match {
    /// The pose.
    pub pose: Pose2D,
    /// How likely the ends of beams are there on average, from 0 to 1.
    pub score: f64,
}

/// Poses that lie in a square of cells, with one heading.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Square {
    /// No pose in it has a higher score.
    bound: f32,
    turn: u16,
    level: u8,
    column: i16,
    row: i16,
}

impl Eq for Square {}
impl PartialOrd for Square {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}
impl Ord for Square {
    /// The highest bound first, and of the same bound the smallest square.
    fn cmp(&self, other: &Self) -> Ordering {
        let key = |of: &Self| (of.turn, of.column, of.row);
        (self.bound.total_cmp(&other.bound))
            .then(other.level.cmp(&self.level))
            .then(key(other).cmp(&key(self)))
    }
}

/// The ends of beams for each heading, in cells from the corner of the grid.
struct MatchSearch<'a> {
    surface: &'a Surface,
    window: &'a Window,
    ends: Vec<(i32, i32)>,
    points: usize,
    turns: i32,
    /// Cells to each side.
    cells: i32,
}

impl Surface {
    /// Returns how many levels a search in a window takes.
    #[must_use]
    pub fn levels(way: f64) -> usize {
        let cells = (2.0 * way / f64::from(CELL)).max(1.0);
        (libm::ceil(libm::log2(cells)) as usize).clamp(1, 8) - 1
    }

    /// Finds the pose of points within a window around a pose. Takes the points that it is given, so give it few.
    #[must_use]
    pub fn search(&self, points: &[SurfacePoint], around: &Pose2D, window: &Window) -> Option<Match> {
        let far = (points.iter().map(|point| libm::hypotf(point.at.0, point.at.1))).fold(1.0, f32::max);
        let numbers = [around.x, around.y, around.theta, f64::from(far)];
        if points.is_empty() || self.levels.is_empty() || !numbers.iter().all(|number| number.is_finite()) {
            return None;
        }
        // The farthest ends move by a cell; but the end of a long beam counts no more than the others.
        let step = f64::from(CELL / far.min(10.0));
        let turns = libm::ceil(window.turn / step).min(1000.0) as i32;
        let mut ends = Vec::with_capacity(points.len() * (2 * turns as usize + 1));
        for turn in -turns..=turns {
            let (sin, cos) = libm::sincos(around.theta + f64::from(turn) * step);
            let place = (around.x as f32, around.y as f32);
            for point in points {
                let (x, y) = self.place(point.moved(place, (sin as f32, cos as f32)).at);
                let cell = |at: f32| libm::floorf(at).clamp(-1e6, 1e6) as i32;
                ends.push((cell(x), cell(y)));
            }
        }
        let search = MatchSearch {
            surface: self,
            window,
            ends,
            points: points.len(),
            turns,
            cells: libm::ceil(window.way / f64::from(CELL)).min(10_000.0) as i32,
        };
        let best = search.best()?;
        Some(Match {
            pose: Pose2D::new(
                around.x + f64::from(best.column) * f64::from(CELL),
                around.y + f64::from(best.row) * f64::from(CELL),
                normalize_angle(around.theta + f64::from(i32::from(best.turn) - turns) * step),
            ),
            score: f64::from(best.bound + search.loss(&best)),
        })
    }
}

impl MatchSearch<'_> {
    fn best(&self) -> Option<Square> {
        let top = self.surface.levels.len() - 1;
        let mut due = BinaryHeap::new();
        let mut looked = 0;
        for turn in 0..=2 * self.turns {
            for row in (-self.cells..=self.cells).step_by(1 << top) {
                for column in (-self.cells..=self.cells).step_by(1 << top) {
                    looked += 1;
                    due.extend(self.square(turn as u16, top as u8, column as i16, row as i16));
                }
            }
        }
        while let Some(square) = due.pop() {
            if square.level == 0 {
                return Some(square);
            }
            if looked > self.window.most {
                return None;
            }
            let (level, half) = (square.level - 1, 1 << (square.level - 1));
            for (dx, dy) in [(0, 0), (half, 0), (0, half), (half, half)] {
                let (column, row) = (square.column + dx, square.row + dy);
                let is_inside = i32::from(column) <= self.cells && i32::from(row) <= self.cells;
                if is_inside {
                    looked += 1;
                    due.extend(self.square(square.turn, level, column, row));
                }
            }
        }
        None
    }

    /// The square, if a pose in it may have the least score.
    fn square(&self, turn: u16, level: u8, column: i16, row: i16) -> Option<Square> {
        let ends = &self.ends[usize::from(turn) * self.points..][..self.points];
        let (x, y) = (i32::from(column), i32::from(row));
        let sum: u32 = (ends.iter())
            .map(|end| u32::from(self.surface.most(level.into(), end.0 + x, end.1 + y)))
            .sum();
        let score = sum as f32 / (255 * self.points) as f32;
        let mut square = Square {
            bound: score,
            turn,
            level,
            column,
            row,
        };
        square.bound -= self.loss(&square);
        (f64::from(square.bound) >= self.window.least).then_some(square)
    }

    /// What the pose of the square nearest to the middle of the window loses.
    fn loss(&self, square: &Square) -> f32 {
        let last = (1 << square.level) - 1;
        let share = |first: i32, last: i32, most: i32| {
            let away = if first > 0 { first } else { (-last).max(0) };
            away as f32 / most.max(1) as f32
        };
        let axis = |first: i16| share(first.into(), i32::from(first) + last, self.cells);
        let turn = i32::from(square.turn) - self.turns;
        let (x, y, turn) = (
            axis(square.column),
            axis(square.row),
            share(turn, turn, self.turns),
        );
        self.window.loss as f32 * (x * x + y * y + turn * turn)
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::icp::Guess;
    use crate::matrix::ZERO;
    use crate::slam::{thin, turn_between};
    use crate::world::World;

    const WINDOW: Window = Window {
        way: 0.5,
        turn: 0.3,
        least: 0.1,
        loss: 0.0,
        most: usize::MAX,
    };

    /// Surfaces at the middle of a random room, and the scan at a pose there.
    fn pair(seed: u64, pose: &Pose2D) -> (Surface, crate::Scan) {
        let world = World::room(seed);
        let mut random = fastrand::Rng::with_seed(seed);
        let here = world.scan(&Pose2D::ORIGIN, &mut random);
        let levels = Surface::levels(WINDOW.way);
        let surface = Surface::new([(Pose2D::ORIGIN, &here)], levels);
        (surface, world.scan(pose, &mut random))
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]

        #[test]
        fn a_shift_in_a_random_room_is_found(
            seed in any::<u64>(), x in -0.45..0.45f64, y in -0.45..0.45f64, turn in -0.28..0.28f64,
        ) {
            let truth = Pose2D::new(x, y, turn);
            let (surface, scan) = pair(seed, &truth);
            let few: Vec<_> = thin(scan.points(), 120).collect();
            let found = surface.search(&few, &Pose2D::ORIGIN, &WINDOW).expect("it is in the window");
            prop_assert!(found.pose.distance_to(&truth) < 0.08, "{found:?}");
            prop_assert!(turn_between(&found.pose, &truth) < 0.03, "{found:?}");
            let guess = Guess { pose: found.pose, information: ZERO };
            let fit = surface.refine(scan.points(), &found.pose, &guess).expect("walls on all sides");
            prop_assert!(fit.pose.distance_to(&truth) < 0.02, "{fit:?}");
            prop_assert!(turn_between(&fit.pose, &truth) < 0.008, "{fit:?}");
            prop_assert!(fit.share > 0.6, "{fit:?}");
        }

        #[test]
        fn no_pose_of_the_window_is_better_than_the_one_found(seed in any::<u64>(), x in -0.3..0.3f64, turn in -0.1..0.1f64) {
            let window = Window { way: 0.3, turn: 0.1, loss: 0.1, ..WINDOW };
            let (surface, scan) = pair(seed, &Pose2D::new(x, 0.1, turn));
            let few: Vec<_> = thin(scan.points(), 40).collect();
            let found = surface.search(&few, &Pose2D::ORIGIN, &window).expect("it is in the window");
            // Windows of one cell and hardly any turn around each pose.
            let one = Window { way: 0.0, turn: 0.0, least: 0.0, loss: 0.0, ..WINDOW };
            let far = few.iter().map(|point| point.at.0.hypot(point.at.1)).fold(1.0, f32::max);
            let step = f64::from(CELL / far.min(10.0));
            let turns = (window.turn / step).ceil();
            let mut best = 0.0_f64;
            for turn in 0..=2 * turns as i32 {
                for (column, row) in (-6..=6).flat_map(|row| (-6..=6).map(move |column| (column, row))) {
                    let (column, row, turn) = (f64::from(column), f64::from(row), f64::from(turn) - turns);
                    let cell = f64::from(CELL);
                    let pose = Pose2D::new(column * cell, row * cell, turn * step);
                    let score = surface.search(&few, &pose, &one).map_or(0.0, |found| found.score);
                    let share = |at: f64, most: f64| at / most * (at / most);
                    let loss = share(column, 6.0) + share(row, 6.0) + share(turn, turns);
                    best = best.max(score - window.loss * loss);
                }
            }
            let loss = |of: &Match| {
                let share = |at: f64, most: f64| at / most * (at / most);
                share(of.pose.x, 0.3) + share(of.pose.y, 0.3) + share(of.pose.theta, turns * step)
            };
            // Ends on the edge of a cell may be counted in the next one.
            prop_assert!((found.score - window.loss * loss(&found) - best).abs() < 0.03, "{found:?}, best {best}");
        }
    }

    #[test]
    fn what_does_not_fit_or_takes_too_long_is_not_found() {
        let (surface, scan) = pair(1, &Pose2D::ORIGIN);
        let few: Vec<_> = thin(scan.points(), 60).collect();
        let find = |window: Window| surface.search(&few, &Pose2D::ORIGIN, &window);
        assert!(find(WINDOW).is_some_and(|found| found.score > 0.8));
        assert_eq!(find(Window { least: 1.0, ..WINDOW }), None);
        assert_eq!(find(Window { most: 10, ..WINDOW }), None);
        assert_eq!(surface.search(&[], &Pose2D::ORIGIN, &WINDOW), None);
        assert_eq!(
            surface.search(&few, &Pose2D::new(f64::NAN, 0.0, 0.0), &WINDOW),
            None
        );
        assert_eq!(surface.search(&few, &Pose2D::new(1e9, 0.0, 0.0), &WINDOW), None);
        let none = Surface::new([], 3);
        assert_eq!(none.search(&few, &Pose2D::ORIGIN, &WINDOW), None);
        let guess = Guess {
            pose: Pose2D::ORIGIN,
            information: ZERO,
        };
        assert_eq!(none.refine(scan.points(), &Pose2D::ORIGIN, &guess), None);
    }
}
