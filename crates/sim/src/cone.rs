//! A cone in which the nearest thing is sought: all of it, not some rays. Every solid is convex, so what a cone sees nearest of one is
//! the solid's own nearest point, or if that is outside the cone lies on an edge of it, where a ray finds it.

use parry2d_f64::bounding_volume::Aabb;
use parry2d_f64::math::Vector;

use crate::solid::{Solid, ray};

/// The inside of a cone of half a turn at most, without its edges.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Cone {
    origin: Vector,
    /// Across the two edges, outwards.
    outwards: [Vector; 2],
}

impl Cone {
    /// With these edges, the one to the right first.
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

    /// How far a box is away at least; nothing if none of it is in the cone, or nearer than `max`.
    pub(crate) fn reaches(&self, area: &Aabb, max: f64) -> Option<f64> {
        let (center, half) = (area.center() - self.origin, area.half_extents());
        let is_outside = |outwards: &Vector| outwards.dot(center) > outwards.abs().dot(half);
        if self.outwards.iter().any(is_outside) {
            return None;
        }
        let gap = (center.abs() - half).max(Vector::ZERO).length();
        (gap < max).then_some(gap)
    }

    /// The distance to the nearest point of a solid, if that is in the cone and nearer than `max`.
    pub(crate) fn sees(&self, solid: &Solid, max: f64) -> Option<f64> {
        let point = solid.nearest(self.origin) - self.origin;
        let distance = point.length();
        let is_inside = self.outwards.iter().all(|outwards| outwards.dot(point) <= 0.0);
        (is_inside && distance < max).then_some(distance)
    }
}
