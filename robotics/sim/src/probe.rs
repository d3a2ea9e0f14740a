//! A ray prepared for many distance queries of axis-aligned boxes, by their slabs (Kay and Kajiya, 1986),
//! without a division.
//!
//! It rejects a box only if the ray hits nothing in it. `solid` computes what the ray hits, and where.

use parry2d_f64::bounding_volume::Aabb;
use parry2d_f64::math::Vector;
use parry2d_f64::query::Ray;

/// How much a box grows for a ray, in metres: far more than the rounding of distances, far less than matters.
const SLACK: f64 = 1e-9;
/// Replaces the inverse of zero: times the slack it exceeds any distance.
const PARALLEL: f64 = 1e300;

/// A ray whose parameter is in metres.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Probe {
    /// The origin for the lower and for the upper sides of boxes. It is shifted by the slack, away from the
    /// sides.
    origin: [Vector; 2],
    /// The reciprocal of the direction.
    inverse: Vector,
}

impl Probe {
    pub(crate) fn of(ray: &Ray) -> Self {
        let inverse = |along: f64| {
            if along == 0.0 {
                PARALLEL
            } else {
                (1.0 / along).clamp(-PARALLEL, PARALLEL)
            }
        };
        Self {
            origin: [
                ray.origin + Vector::splat(SLACK),
                ray.origin - Vector::splat(SLACK),
            ],
            inverse: Vector::new(inverse(ray.dir.x), inverse(ray.dir.y)),
        }
    }

    /// Returns a lower bound of the distance along the ray to the box, 0 from inside it; `None` if the ray
    /// misses the box, or reaches it after `max` metres.
    #[inline]
    pub(crate) fn range_to_box(&self, area: &Aabb, max: f64) -> Option<f64> {
        let (a, b) = (
            (area.mins - self.origin[0]) * self.inverse,
            (area.maxs - self.origin[1]) * self.inverse,
        );
        let enters = a.x.min(b.x).max(a.y.min(b.y)).max(0.0);
        let leaves = a.x.max(b.x).min(a.y.max(b.y));
        (enters <= leaves && enters <= max).then_some(enters)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns the distance along a ray to a box between these corners, to the micrometre.
    fn reached(from: [f64; 2], to: [f64; 2], origin: [f64; 2], direction: [f64; 2]) -> Option<f64> {
        let area = Aabb::new(from.into(), to.into());
        let reached = Probe::of(&Ray::new(origin.into(), direction.into())).range_to_box(&area, 100.0);
        reached.map(|distance| (distance * 1e6).round() / 1e6)
    }

    #[test]
    fn a_ray_reaches_a_box_at_its_near_side() {
        assert_eq!(
            reached([2.0, -1.0], [3.0, 1.0], [0.0, 0.0], [1.0, 0.0]),
            Some(2.0)
        );
        assert_eq!(
            reached([-1.0, -4.0], [1.0, -3.0], [0.0, 0.0], [0.0, -1.0]),
            Some(3.0)
        );
    }

    #[test]
    fn a_ray_from_inside_a_box_has_distance_0() {
        assert_eq!(
            reached([-1.0, -1.0], [1.0, 1.0], [0.0, 0.0], [0.6, 0.8]),
            Some(0.0)
        );
    }

    #[test]
    fn a_ray_misses_boxes_beside_behind_or_too_far() {
        assert_eq!(reached([2.0, 1.0], [3.0, 2.0], [0.0, 0.0], [1.0, 0.0]), None);
        assert_eq!(reached([-3.0, -1.0], [-2.0, 1.0], [0.0, 0.0], [1.0, 0.0]), None);
        assert_eq!(reached([101.0, -1.0], [102.0, 1.0], [0.0, 0.0], [1.0, 0.0]), None);
    }

    #[test]
    fn a_ray_reaches_a_box_without_thickness_from_the_front_and_along_its_edge() {
        assert_eq!(
            reached([2.0, -1.0], [2.0, 1.0], [0.0, 0.0], [1.0, 0.0]),
            Some(2.0)
        );
        assert_eq!(reached([2.0, 0.0], [5.0, 0.0], [0.0, 0.0], [1.0, 0.0]), Some(2.0));
        assert_eq!(
            reached([2.0, 0.0], [5.0, 0.0], [0.0, 0.0], [1.0, -0.0]),
            Some(2.0)
        );
        // Along one side of a box with a thickness.
        assert_eq!(
            reached([2.0, -1.0], [3.0, 0.0], [0.0, 0.0], [1.0, 0.0]),
            Some(2.0)
        );
    }
}
