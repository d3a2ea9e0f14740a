//! The path as the critics need it: points along it within the horizon.

use wide::f32x8;

/// The greatest number of points.
const CAPACITY: usize = 48;
/// How much farther along the path than the base can drive a point may be and still count, m. So a path that
/// returns on the other side of a wall draws nothing through the wall.
const SLACK: f32 = 0.15;
/// The cosine of the angle up to which a place is ahead: 45°.
const AHEAD: f32 = core::f32::consts::FRAC_1_SQRT_2;

/// The part of a path within the horizon.
#[derive(Clone, Debug, Default)]
pub struct Guide {
    points: Vec<Point>,
    /// Where the base should face in the end, rad; `None` if that does not matter.
    pub heading: Option<f32>,
}

#[derive(Clone, Copy, Debug)]
struct Point {
    x: f32,
    y: f32,
    /// The direction of the path, of length 1; zero at its end.
    along: (f32, f32),
    /// The way from the first point, m.
    way: f32,
}

impl Guide {
    /// Returns an empty guide with room for all points.
    #[must_use]
    pub fn new() -> Self {
        Self {
            points: Vec::with_capacity(CAPACITY),
            heading: None,
        }
    }

    /// Replaces the path by `places`, from the place beside a robot at `pose` on; at most 48 count. If their
    /// end is not ahead of it, the robot should face it.
    pub fn follow(
        &mut self,
        [from_x, from_y, heading]: [f32; 3],
        places: impl IntoIterator<Item = (f32, f32)>,
    ) {
        self.points.clear();
        for (x, y) in places.into_iter().take(CAPACITY) {
            let mut way = 0.0;
            if let Some(last) = self.points.last_mut() {
                let (dx, dy) = (x - last.x, y - last.y);
                let length = libm::hypotf(dx, dy);
                if length < 1e-4 {
                    continue;
                }
                last.along = (dx / length, dy / length);
                way = last.way + length;
            }
            let along = (0.0, 0.0);
            self.points.push(Point { x, y, along, way });
        }
        let bearing = self
            .points
            .last()
            .map(|last| libm::atan2f(last.y - from_y, last.x - from_x));
        self.heading = bearing.filter(|bearing| libm::cosf(bearing - heading) < AHEAD);
    }

    /// The length of the path, m.
    pub(crate) fn length(&self) -> f32 {
        self.points.last().map_or(0.0, |point| point.way)
    }

    /// The squared distances of eight places to the path, m², and the ways along it to the points nearest to
    /// them, m. Only points within `reach` m along the path count.
    pub(crate) fn nearest(&self, x: f32x8, y: f32x8, reach: f32) -> (f32x8, f32x8) {
        let mut least = f32x8::splat(f32::MAX);
        let mut way = f32x8::ZERO;
        for point in self.points.iter().take_while(|point| point.way <= reach + SLACK) {
            let (dx, dy) = (x - f32x8::splat(point.x), y - f32x8::splat(point.y));
            let square = dx * dx + dy * dy;
            let along = dx * f32x8::splat(point.along.0) + dy * f32x8::splat(point.along.1);
            let is_nearer = square.simd_lt(least);
            least = is_nearer.select(square, least);
            way = is_nearer.select(f32x8::splat(point.way) + along, way);
        }
        (least, way.fast_min(f32x8::splat(self.length())))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn first((square, way): (f32x8, f32x8)) -> (f32, f32) {
        (square.to_array()[0], way.to_array()[0])
    }

    #[test]
    fn a_place_beside_the_path_has_the_way_of_its_foot() {
        let mut guide = Guide::new();
        guide.follow([0.0; 3], (0..11).map(|at| (0.1 * at as f32, 0.0)));
        let at = |x, y, reach| first(guide.nearest(f32x8::splat(x), f32x8::splat(y), reach));
        let (square, way) = at(0.52, 0.3, 9.0);
        assert!(
            (way - 0.52).abs() < 1e-5 && (square - 0.0904).abs() < 1e-4,
            "{way}"
        );
        assert!((at(1.4, 0.0, 9.0).1 - 1.0).abs() < 1e-5, "not beyond the end");
        assert!((at(-0.2, 0.0, 9.0).1 + 0.2).abs() < 1e-5, "behind the start");
    }

    #[test]
    fn a_part_that_the_base_cannot_reach_yet_draws_nothing() {
        let mut guide = Guide::new();
        // Around the end of a wall, back on its other side.
        let out = (0..8).map(|at| (0.1 * at as f32, 0.0));
        let back = (0..8).map(|at| (0.7 - 0.1 * at as f32, 0.2));
        guide.follow([0.0; 3], out.chain(back));
        let at = |reach| first(guide.nearest(f32x8::splat(0.0), f32x8::splat(0.15), reach)).1;
        assert!(at(0.4) < 0.1 && at(9.0) > 1.5);
    }
}
