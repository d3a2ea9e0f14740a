//! How far the nearest obstacle is from each place around the robot.

use wide::f32x8;

/// A grid of distances to the nearest obstacle, row by row from the zero of the frame along its axes.
#[derive(Clone, Debug)]
pub struct Clearance {
    width: usize,
    resolution: f32,
    distances: Vec<f32>,
}

impl Clearance {
    /// Returns a grid of `width` × `width` cells with sides of `resolution` metres, without obstacles.
    #[must_use]
    pub fn new(width: usize, resolution: f32) -> Self {
        Self {
            width,
            resolution,
            distances: vec![f32::MAX; width * width],
        }
    }

    /// Replaces the distances by the squares of those in cells, row by row; `u32::MAX` is none.
    pub fn set_squares(&mut self, squares: &[u32]) {
        for (distance, &square) in self.distances.iter_mut().zip(squares) {
            *distance = match square {
                u32::MAX => f32::MAX,
                square => libm::sqrtf(square as f32) * self.resolution,
            };
        }
    }

    /// The distances at eight places, m; outside the grid, those of its edge.
    pub(crate) fn at(&self, x: f32x8, y: f32x8) -> f32x8 {
        let last = f32x8::splat(self.width.saturating_sub(1) as f32);
        let scale = f32x8::splat(1.0 / self.resolution);
        // A comparison with NaN takes the second operand: zero.
        let cell = |value: f32x8| {
            (value * scale)
                .fast_max(f32x8::ZERO)
                .fast_min(last)
                .fast_trunc_int()
                .to_array()
        };
        let (columns, rows) = (cell(x), cell(y));
        let at = |lane: usize| {
            let index = rows[lane] as usize * self.width + columns[lane] as usize;
            self.distances.get(index).copied().unwrap_or(f32::MAX)
        };
        f32x8::from(core::array::from_fn(at))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_outside_have_the_distance_of_the_edge() {
        let mut clearance = Clearance::new(3, 0.1);
        clearance.set_squares(&[0, 1, 4, 1, 2, 5, 4, 5, u32::MAX]);
        let x = f32x8::from([0.05, 0.15, 0.25, -1.0, 0.25, 9.0, f32::NAN, 0.25]);
        let y = f32x8::from([0.05, 0.15, 0.05, -1.0, 0.25, 0.05, 0.05, 0.15]);
        let found = clearance.at(x, y).to_array();
        let expected = [0.0, 0.141_42, 0.2, 0.0, f32::MAX, 0.2, 0.0, 0.223_61];
        for (found, expected) in found.into_iter().zip(expected) {
            assert!((found - expected).abs() < 1e-4, "{found} for {expected}");
        }
    }
}
