//! A cone in which the nearest thing is sought: the whole cone, not only some rays. Every solid is convex. So
//! its nearest point in a cone is its nearest point of all, or lies on an edge of the cone, where a ray finds
//! it.

use parry2d_f64::bounding_volume::Aabb;
use parry2d_f64::math::Vector;
use parry2d_f64::query::Ray;

use crate::solid::{Solid, ray};

/// How much a box grows, in metres: far more than the rounding of distances, so that no ray along an edge hits
/// a solid outside of its box.
const SLACK: f64 = 1e-9;

/// A cone of at most half a turn.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Cone {
    origin: Vector,
    edges: [Ray; 2],
    /// The outward normals of the two edges.
    outwards: [Vector; 2],
}

impl Cone {
    /// Creates a cone with these edges: `right` first, then `left`, in radians.
    pub(crate) fn new(origin: [f64; 2], right: f64, left: f64) -> Self {
        let edges = [ray(origin, right), ray(origin, left)];
        let [right, left] = edges.map(|edge| edge.dir);
        Self {
            origin: Vector::from(origin),
            edges,
            outwards: [Vector::new(right.y, -right.x), Vector::new(-left.y, left.x)],
        }
    }

    /// Returns a lower bound of the distance to a box; `None` if the box is outside the cone, or not nearer
    /// than `max`.
    pub(crate) fn range_to_box(&self, area: &Aabb, max: f64) -> Option<f64> {
        let (center, half) = (area.center() - self.origin, area.half_extents());
        let is_outside = |outwards: &Vector| outwards.dot(center) > outwards.abs().dot(half) + SLACK;
        if self.outwards.iter().any(is_outside) {
            return None;
        }
        let gap = (center.abs() - half).max(Vector::ZERO).length() - SLACK;
        (gap < max).then_some(gap)
    }

    /// Returns the distance to the nearest point of a solid in the cone, if it is nearer than `max`.
    pub(crate) fn range_to(&self, solid: &Solid, max: f64) -> Option<f64> {
        let mut nearest = None;
        for edge in &self.edges {
            nearest = solid.cast_ray(edge, nearest.unwrap_or(max)).or(nearest);
        }
        let point = solid.nearest(self.origin) - self.origin;
        let distance = point.length();
        let is_inside = self.outwards.iter().all(|outwards| outwards.dot(point) <= 0.0);
        if is_inside && distance < nearest.unwrap_or(max) {
            nearest = Some(distance);
        }
        nearest
    }
}
