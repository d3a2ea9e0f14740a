//! Outlines and bodies of robots as solids: rays, distances and nearest points, all by parry's formulas.
//!
//! This module does not depend on names, time or robots.

use std::sync::Arc;

use parry2d_f64::bounding_volume::Aabb;
use parry2d_f64::math::{Pose, Rotation, Vector};
use parry2d_f64::query::{self, ClosestPoints, Ray, RayCast};
use parry2d_f64::shape::{Ball, ConvexPolygon, Cuboid, Segment, Shape};

use crate::geometry::Pose2;
use crate::shape::Outline;

/// How much longer a wall is at each end, in metres, so that a ray cannot pass through a rounding error
/// between two walls that share a corner.
const OVERLAP: f64 = 1e-9;
/// The least depth of an overlap, in metres: touching counts as one.
const TOUCH: f64 = 1e-9;
/// The reflectivity of what states none: paint, wood and cloth, by estimate.
pub(crate) const REFLECTIVITY: f64 = 0.5;

/// What a laser and a camera find of a thing. Sonars, bumpers and bodies meet all of it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum Surface {
    /// All of it.
    #[default]
    Opaque,
    /// Nothing: light passes through.
    Glass,
    /// A laser gets nothing back; a camera sees it.
    Black,
    /// A laser passes below it; a camera sees its top.
    Tabletop,
}

#[derive(Clone, Debug)]
pub(crate) struct Solid {
    pose: Pose,
    geometry: Geometry,
    reflectivity: f64,
    surface: Surface,
    /// Metres from the floor; a laser that is higher passes over it.
    height: f64,
}

#[derive(Clone, Debug)]
enum Geometry {
    Segment(Segment),
    Box(Cuboid),
    Circle(Ball),
    Polygon(Arc<ConvexPolygon>),
}

impl Solid {
    pub(crate) fn new(outline: &Outline) -> Self {
        let (pose, geometry) = match *outline {
            Outline::Segment { from, to } => {
                let (from, to) = (Vector::from(from), Vector::from(to));
                let extra = (to - from).normalize() * OVERLAP;
                let segment = Segment::new(from - extra, to + extra);
                (Pose::IDENTITY, Geometry::Segment(segment))
            }
            Outline::Box { center, size, angle } => (
                Pose::from_parts(Vector::from(center), rotation(angle)),
                Geometry::Box(Cuboid::new(Vector::from(size) / 2.0)),
            ),
            Outline::Circle { center, radius } => (
                Pose::from_translation(Vector::from(center)),
                Geometry::Circle(Ball::new(radius)),
            ),
        };
        Self {
            pose,
            geometry,
            reflectivity: REFLECTIVITY,
            surface: Surface::Opaque,
            height: f64::INFINITY,
        }
    }

    /// Returns the solid with a height.
    pub(crate) fn of_height(self, height: f64) -> Self {
        Self { height, ..self }
    }

    /// Returns the solid with a reflectivity and a surface.
    pub(crate) fn reflecting(self, reflectivity: f64, surface: Surface) -> Self {
        Self {
            reflectivity,
            surface,
            ..self
        }
    }

    /// Returns whether a laser at a height passes it as if it were not there.
    pub(crate) fn lets_light_pass(&self, height: f64) -> bool {
        height > self.height || matches!(self.surface, Surface::Glass | Surface::Tabletop)
    }

    /// Returns the distance at which a laser at a height meets it, if that is nearer than `max`.
    pub(crate) fn cast_light(&self, ray: &Ray, max: f64, height: f64) -> Option<f64> {
        if self.lets_light_pass(height) {
            return None;
        }
        self.cast_ray(ray, max)
    }

    /// Returns whether a laser gets nothing back from it.
    pub(crate) fn is_black(&self) -> bool {
        self.surface == Surface::Black
    }

    /// Returns how bright it is to a laser: 1 for a white surface.
    pub(crate) fn reflectivity(&self) -> f64 {
        self.reflectivity
    }

    pub(crate) fn polygon(pose: Pose2, polygon: Arc<ConvexPolygon>) -> Self {
        Self {
            pose: Pose::from_parts(Vector::new(pose.x, pose.y), rotation(pose.heading)),
            geometry: Geometry::Polygon(polygon),
            reflectivity: REFLECTIVITY,
            surface: Surface::Opaque,
            height: f64::INFINITY,
        }
    }

    /// Returns the distance along a unit ray to the solid: 0 from inside, `None` beyond `max` metres.
    pub(crate) fn cast_ray(&self, ray: &Ray, max: f64) -> Option<f64> {
        match &self.geometry {
            Geometry::Segment(segment) => segment.cast_local_ray(ray, max, true),
            Geometry::Box(cuboid) => cuboid.cast_ray(&self.pose, ray, max, true),
            Geometry::Circle(ball) => ball.cast_ray(&self.pose, ray, max, true),
            Geometry::Polygon(polygon) => polygon.cast_ray(&self.pose, ray, max, true),
        }
    }

    /// Returns the point of the solid nearest to `point`: `point` itself inside the solid.
    pub(crate) fn nearest(&self, point: Vector) -> Vector {
        self.geometry.shape().project_point(&self.pose, point, true).point
    }

    pub(crate) fn distance_to_point(&self, point: Vector) -> f64 {
        self.nearest(point).distance(point)
    }

    /// Returns the gap between two solids: 0 on overlap.
    pub(crate) fn distance_to_solid(&self, other: &Self) -> f64 {
        query::distance(
            &self.pose,
            self.geometry.shape(),
            &other.pose,
            other.geometry.shape(),
        )
        .map_or(f64::INFINITY, |found| found.distance)
    }

    /// Returns the gap between two solids: on overlap the depth, as a negative number.
    pub(crate) fn gap_to_solid(&self, other: &Self) -> f64 {
        let distance = self.distance_to_solid(other);
        if distance > 0.0 {
            return distance;
        }
        let (one, two) = (self.geometry.shape(), other.geometry.shape());
        let contact = query::contact(&self.pose, one, &other.pose, two, 0.0);
        contact
            .ok()
            .flatten()
            .map_or(-TOUCH, |contact| contact.dist.min(-TOUCH))
    }

    /// Returns the point of another solid nearest to this one, if the gap is smaller than `reach` metres. For
    /// two solids that overlap there is none.
    pub(crate) fn contact(&self, other: &Self, reach: f64) -> Option<Vector> {
        let (one, two) = (self.geometry.shape(), other.geometry.shape());
        match query::closest_points(&self.pose, one, &other.pose, two, reach) {
            Ok(ClosestPoints::WithinMargin(_, point)) => Some(point),
            Ok(ClosestPoints::Intersecting | ClosestPoints::Disjoint) | Err(_) => None,
        }
    }

    pub(crate) fn aabb(&self) -> Aabb {
        self.geometry.shape().compute_aabb(&self.pose)
    }
}

impl Geometry {
    fn shape(&self) -> &dyn Shape {
        match self {
            Self::Segment(segment) => segment,
            Self::Box(cuboid) => cuboid,
            Self::Circle(ball) => ball,
            Self::Polygon(polygon) => &**polygon,
        }
    }
}

/// A ray whose parameter is in metres.
pub(crate) fn ray(origin: [f64; 2], angle: f64) -> Ray {
    let (sin, cos) = libm::sincos(angle);
    Ray::new(Vector::from(origin), Vector::new(cos, sin))
}

fn rotation(angle: f64) -> Rotation {
    let (sin, cos) = libm::sincos(angle);
    Rotation { re: cos, im: sin }
}
