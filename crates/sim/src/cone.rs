//! A cone in which the nearest thing is sought: the whole cone, not only some rays. Every solid is convex. So
//! its nearest point in a cone is its nearest point of all, or lies on an edge of the cone, where a ray finds
//! it.

use parry2d_f64::bounding_volume::Aabb;
use parry2d_f64::math::Vector;

use crate::solid::{Solid, ray};

/// The inside of a cone of at most half a turn, without its edges.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Cone {
    origin: Vector,
    /// The outward normals of the two edges.
    outwards: [Vector; 2],
}

impl Cone {
    /// Creates a cone with these edges: `right` first, then `left`, in radians.
    pub(crate) fn new(origin: [f64; 2], right: f64, left: f64) -> Self {
        let across = |angle: f64, side: f64| {
            let along = ray(origin, angle).dir;
            Vector::new(-side * along.y, side * along.x)
        };
        Self {
            origin: Vector::from(origin),
            outwards: [across(right, -1.0), across(left, 1.0)],
        }
    }

    /// Returns a lower bound of the distance to a box; `None` if the box is outside the cone, or not nearer
    /// than `max`.
    pub(crate) fn range_to_box(&self, area: &Aabb, max: f64) -> Option<f64> {
        let (center, half) = (area.center() - self.origin, area.half_extents());
        let is_outside = |outwards: &Vector| outwards.dot(center) > outwards.abs().dot(half);
        if self.outwards.iter().any(is_outside) {
            return None;
        }
        let gap = (center.abs() - half).max(Vector::ZERO).length();
        (gap < max).then_some(gap)
    }

    /// Returns the distance to the nearest point of a solid, if that point is in the cone and nearer than
    /// `max`.
    pub(crate) fn range_to(&self, solid: &Solid, max: f64) -> Option<f64> {
        let point = solid.nearest(self.origin) - self.origin;
        let distance = point.length();
        let is_inside = self.outwards.iter().all(|outwards| outwards.dot(point) <= 0.0);
        (is_inside && distance < max).then_some(distance)
    }
}
