//! Many rays from one point at equal angles, as a laser casts them. Each solid meets only the rays that can
//! reach its bounding box, which costs far less than a search of the whole scene for each ray.
//!
//! The distances are the same to the bit as those of single rays.

use std::f64::consts::TAU;
use std::ops::Range;

use parry2d_f64::bounding_volume::Aabb;
use parry2d_f64::math::Vector;
use parry2d_f64::query::Ray;

use crate::solid::{self, Solid};

/// A box this near, in metres, meets all rays: the directions to its corners would be inaccurate.
const TOO_NEAR: f64 = 1e-3;
/// By how much less the distance to a box counts, in metres: far more than the rounding of distances.
const SLACK: f64 = 1e-9;

/// What a ray meets first.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Echo {
    /// Metres.
    pub(crate) distance: f64,
    /// Of the solid: 1 for a white surface.
    pub(crate) reflectivity: f64,
    /// Whether nothing comes back.
    pub(crate) is_black: bool,
}

impl Echo {
    /// Creates the echo of a solid at a distance.
    pub(crate) fn of(solid: &Solid, distance: f64) -> Self {
        Self {
            distance,
            reflectivity: solid.reflectivity(),
            is_black: solid.is_black(),
        }
    }
}

/// Rays from one point, counter-clockwise, with the first solid on each.
pub(crate) struct Sweep {
    origin: Vector,
    rays: Vec<Ray>,
    nearest: Vec<Option<Echo>>,
    /// The direction of the first ray, and the angle between neighbours, in radians.
    first: f64,
    increment: f64,
    max: f64,
    /// Of the laser above the floor, in metres.
    height: f64,
}

impl Sweep {
    /// Creates rays of `max` metres at these angles, each `increment` after the one before it, at a height above the
    /// floor.
    pub(crate) fn new(
        origin: [f64; 2],
        angles: impl Iterator<Item = f64>,
        increment: f64,
        (max, height): (f64, f64),
    ) -> Self {
        let mut angles = angles.peekable();
        let first = angles.peek().copied().unwrap_or_default();
        let rays: Vec<Ray> = angles.map(|angle| solid::ray(origin, angle)).collect();
        Self {
            origin: Vector::from(origin),
            nearest: vec![None; rays.len()],
            rays,
            first,
            increment,
            max,
            height,
        }
    }

    pub(crate) fn rays(&self) -> &[Ray] {
        &self.rays
    }

    pub(crate) fn max(&self) -> f64 {
        self.max
    }

    pub(crate) fn height(&self) -> f64 {
        self.height
    }

    /// Returns the first solid that each ray met.
    pub(crate) fn into_echoes(self) -> Vec<Option<Echo>> {
        self.nearest
    }

    pub(crate) fn echoes_mut(&mut self) -> &mut [Option<Echo>] {
        &mut self.nearest
    }

    /// Returns a lower bound of the distance to a box; `None` if it exceeds the length of the rays.
    #[inline]
    pub(crate) fn range_to_box(&self, area: &Aabb) -> Option<f64> {
        let gap = (area.mins - self.origin).max(self.origin - area.maxs);
        let range = gap.max(Vector::ZERO).length() - SLACK;
        (range <= self.max).then_some(range)
    }

    /// Casts the rays that can reach a solid at it.
    pub(crate) fn meet(&mut self, solid: &Solid) {
        if solid.lets_light_pass(self.height) {
            return;
        }
        let area = solid.aabb();
        let Some(range) = self.range_to_box(&area) else {
            return;
        };
        for beams in self.beams_to_box(&area) {
            for (ray, nearest) in self.rays[beams.clone()].iter().zip(&mut self.nearest[beams]) {
                let limit = nearest.map_or(self.max, |echo| echo.distance);
                if range <= limit
                    && let Some(distance) = solid.cast_ray(ray, limit)
                {
                    *nearest = Some(Echo::of(solid, distance));
                }
            }
        }
    }

    /// Returns the numbers of the rays that can reach a box, in two parts, because the box may lie across the
    /// direction of the first ray.
    fn beams_to_box(&self, area: &Aabb) -> [Range<usize>; 2] {
        let (low, high) = (area.mins - self.origin, area.maxs - self.origin);
        let is_near = low.max(-high).max_element() <= TOO_NEAR;
        if is_near {
            return [0..self.rays.len(), 0..0];
        }
        let [right, left] = silhouette(low, high).map(|corner| libm::atan2(corner.y, corner.x));
        let start = (right - self.first).rem_euclid(TAU);
        let end = start + (left - right).rem_euclid(TAU);
        // One ray more on each side: the angles are rounded.
        let beam = |angle: f64, more: f64| {
            let beam = (angle / self.increment).floor() + more;
            beam.clamp(0.0, self.rays.len() as f64) as usize
        };
        [0.0, TAU].map(|turn| beam(start - turn, -1.0)..beam(end - turn, 3.0))
    }
}

/// Returns the rightmost and the leftmost corner of a box as seen from the origin, which is outside of it.
fn silhouette(low: Vector, high: Vector) -> [Vector; 2] {
    let corner = Vector::new;
    if low.x > 0.0 {
        let right = corner(if low.y < 0.0 { low.x } else { high.x }, low.y);
        [right, corner(if high.y > 0.0 { low.x } else { high.x }, high.y)]
    } else if high.x < 0.0 {
        let right = corner(if high.y > 0.0 { high.x } else { low.x }, high.y);
        [right, corner(if low.y < 0.0 { high.x } else { low.x }, low.y)]
    } else if low.y > 0.0 {
        [corner(high.x, low.y), corner(low.x, low.y)]
    } else {
        [corner(low.x, high.y), corner(high.x, high.y)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::{Noise, Purpose};
    use crate::shape::Outline;

    /// Solids of all kinds around the origin, the same for the same seed.
    fn solids(seed: u64) -> Vec<Solid> {
        let draws = |index: u32| Noise::new(seed, 0, Purpose::Laser, 0, 0).normals(index);
        let solid = |index: u32| {
            let ([x, y], [a, b]) = (draws(3 * index), draws(3 * index + 1));
            let center = [3.0 * x, 3.0 * y];
            Solid::new(&match index % 4 {
                0 => Outline::Segment {
                    from: center,
                    to: [center[0] + a, center[1] + b],
                },
                // Along an axis, as most walls are.
                1 => Outline::Segment {
                    from: center,
                    to: [center[0] + 3.0 * a, center[1]],
                },
                2 => Outline::Box {
                    center,
                    size: [a.abs() + 0.01, b.abs() + 0.01],
                    angle: draws(3 * index + 2)[0],
                },
                _ => Outline::Circle {
                    center,
                    radius: a.abs() / 2.0 + 0.01,
                },
            })
        };
        (0..24).map(solid).collect()
    }

    #[test]
    fn a_sweep_measures_the_same_as_single_rays_to_the_bit() {
        for seed in 0..100 {
            let solids = solids(seed);
            let [x, y] = Noise::new(seed, 1, Purpose::Laser, 0, 0).normals(0);
            let (origin, heading) = ([x, y], x - y);
            for (beams, view) in [(360, TAU), (181, 3.2), (4, TAU), (1, 0.1), (90, 0.02)] {
                let increment = view / f64::from(beams);
                let angle = |beam| heading - view / 2.0 + f64::from(beam) * increment;
                let mut sweep = Sweep::new(origin, (0..beams).map(angle), increment, (4.0, 0.0));
                solids.iter().for_each(|solid| sweep.meet(solid));
                let alone = (0..beams).map(|beam| {
                    let ray = solid::ray(origin, angle(beam));
                    let hits = solids.iter().filter_map(|solid| solid.cast_ray(&ray, 4.0));
                    hits.min_by(f64::total_cmp)
                });
                let echoes = sweep.into_echoes().into_iter();
                assert_eq!(
                    echoes.map(|echo| Some(echo?.distance)).collect::<Vec<_>>(),
                    alone.collect::<Vec<_>>(),
                    "{seed}: {beams} beams"
                );
            }
        }
    }
}
