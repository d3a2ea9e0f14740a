//! The outline of a robot's body, as seen from above: a circle, or a convex polygon.
//!
//! It has no height, and refuses outlines that are not convex or that do not contain the robot's centre.

use std::f64::consts::TAU;
use std::sync::Arc;

use parry2d_f64::math::Vector;
use parry2d_f64::shape::ConvexPolygon;

use crate::error::{WorldError, check};
use crate::geometry::Pose2;
use crate::shape::Outline;
use crate::solid::Solid;

/// Most corners of a polygon: more would slow every query without a visible difference.
const MAX_CORNERS: usize = 64;
/// The least width of a body in metres. One that is much smaller than a step could pass through a wall.
const MIN_WIDTH: f64 = 0.02;
/// The largest distance of a corner from the centre, in metres.
const MAX_RADIUS: f64 = 10.0;
/// How many pieces of a motion the width of a body is long. No wall is so thin that it fits between two of
/// them.
const PIECES: f64 = 100.0;

/// The outline of a robot's body, in the robot's frame.
#[derive(Clone, Debug, PartialEq)]
pub enum Footprint {
    /// A disc around the centre. It can turn anywhere.
    Circle {
        /// Its radius in metres.
        radius: f64,
    },
    /// A convex polygon. It turns only where its corners have room.
    Polygon(Polygon),
}

/// A convex polygon that contains the robot's centre, about which it turns.
#[derive(Clone, Debug)]
pub struct Polygon {
    shape: Arc<ConvexPolygon>,
    /// The distance of the farthest corner from the centre, in metres.
    radius: f64,
    /// The least distance of two parallel lines with the polygon between them, in metres.
    width: f64,
}

/// The body of a robot at a pose.
#[derive(Clone, Debug)]
pub(crate) struct RobotBody {
    center: Vector,
    /// Of the circle around its centre that contains it, in metres.
    radius: f64,
    /// `Some` for a polygon only.
    polygon: Option<Solid>,
}

impl Footprint {
    /// Creates a polygon from its corners in metres, in either order.
    ///
    /// # Errors
    /// Fewer than 3 or more than 64 corners, a number that is not finite, corners that are not those of a
    /// convex polygon around the centre, one that is narrower than 2 cm or reaches farther than 10 m.
    pub fn polygon(corners: &[[f64; 2]]) -> Result<Self, WorldError> {
        Polygon::new(corners)
            .map(Self::Polygon)
            .map_err(|reason| WorldError::BadFootprint { reason })
    }

    /// Returns the radius in metres of the smallest circle around the centre that contains the body.
    pub fn radius(&self) -> f64 {
        match self {
            Self::Circle { radius } => *radius,
            Self::Polygon(polygon) => polygon.radius,
        }
    }

    /// Returns the corners of the smallest box that contains the body, in the robot's frame: least x and y
    /// first.
    pub fn extent(&self) -> [[f64; 2]; 2] {
        match self {
            Self::Circle { radius } => [[-radius; 2], [*radius; 2]],
            Self::Polygon(polygon) => {
                let area = polygon.shape.local_aabb();
                [area.mins.into(), area.maxs.into()]
            }
        }
    }

    /// Returns the corners in metres, counter-clockwise; none for a circle.
    pub fn corners(&self) -> impl Iterator<Item = [f64; 2]> {
        let corners = match self {
            Self::Circle { .. } => &[],
            Self::Polygon(polygon) => polygon.shape.points(),
        };
        corners.iter().map(|&corner| corner.into())
    }

    pub(crate) fn check(&self) -> Result<(), WorldError> {
        match self {
            Self::Circle { radius } => check("radius", *radius, "0.01 to 10 m", |value| {
                (MIN_WIDTH / 2.0..=MAX_RADIUS).contains(&value)
            }),
            // Checked when it was created.
            Self::Polygon(_) => Ok(()),
        }
    }

    pub(crate) fn at(&self, pose: Pose2) -> RobotBody {
        RobotBody {
            center: Vector::new(pose.x, pose.y),
            radius: self.radius(),
            polygon: match self {
                Self::Circle { .. } => None,
                Self::Polygon(polygon) => Some(Solid::polygon(pose, polygon.shape.clone())),
            },
        }
    }

    /// Returns the greatest distance that a point of the body moves, as far as the surroundings feel it: a
    /// circle can turn without touching anything.
    pub(crate) fn travel(&self, distance: f64, turn: f64) -> f64 {
        match self {
            Self::Circle { .. } => distance,
            Self::Polygon(polygon) => distance + polygon.radius * turn.abs(),
        }
    }

    /// Returns the number of pieces into which a motion is cut. A piece is so short compared with the body
    /// that the body cannot pass through the thinnest wall between two pieces.
    pub(crate) fn pieces(&self, travel: f64) -> f64 {
        let piece = match self {
            Self::Circle { radius } => radius / (PIECES / 2.0),
            Self::Polygon(polygon) => polygon.width / PIECES,
        };
        (travel / piece).ceil()
    }
}

impl PartialEq for Polygon {
    fn eq(&self, other: &Self) -> bool {
        self.shape.points() == other.shape.points()
    }
}

impl Polygon {
    pub(crate) fn new(corners: &[[f64; 2]]) -> Result<Self, String> {
        if !(3..=MAX_CORNERS).contains(&corners.len()) {
            return Err(format!(
                "has {} corners: expected 3 to {MAX_CORNERS}",
                corners.len()
            ));
        }
        let mut corners: Vec<Vector> = corners.iter().map(|&corner| Vector::from(corner)).collect();
        let radius = corners.iter().map(|corner| corner.length()).fold(0.0, f64::max);
        if !corners.iter().all(|corner| corner.is_finite()) || radius > MAX_RADIUS {
            return Err(format!(
                "reaches {radius} m: expected finite numbers, at most {MAX_RADIUS} m from the centre"
            ));
        }
        if sides_of(&corners)
            .map(|[from, to]| from.perp_dot(to))
            .sum::<f64>()
            < 0.0
        {
            corners.reverse();
        }
        let sides = || sides_of(&corners);
        let bends = sides()
            .zip(sides().skip(1).chain(sides()))
            .all(|([from, by], [_, to])| (by - from).perp_dot(to - by) >= 0.0);
        let angle = |[from, to]: [Vector; 2]| libm::atan2(from.perp_dot(to), from.dot(to));
        // A star bends one way, too, but goes around twice.
        if !bends || sides().map(angle).sum::<f64>() > 1.5 * TAU {
            return Err(
                "is not convex: expected corners in order around the body, without a dent".to_owned(),
            );
        }
        if !sides().all(|[from, to]| from.perp_dot(to) > 0.0) {
            let reason =
                "does not contain (0, 0): expected a polygon around the point about which the robot turns";
            return Err(reason.to_owned());
        }
        let width = sides()
            .map(|[from, to]| {
                let along = (to - from).normalize();
                let depths = corners.iter().map(|corner| along.perp_dot(*corner - from));
                depths.fold(0.0, f64::max)
            })
            .fold(f64::INFINITY, f64::min);
        if width < MIN_WIDTH {
            return Err(format!("is {width} m wide: expected at least {MIN_WIDTH} m"));
        }
        let shape = ConvexPolygon::from_convex_polyline(corners)
            .ok_or_else(|| "has its corners on one line: expected an area".to_owned())?;
        Ok(Self {
            shape: Arc::new(shape),
            radius,
            width,
        })
    }
}

impl RobotBody {
    pub(crate) fn center(&self) -> Vector {
        self.center
    }

    /// Returns the radius in metres of the circle around its centre that contains it.
    pub(crate) fn radius(&self) -> f64 {
        self.radius
    }

    /// Returns its solid.
    pub(crate) fn solid(&self) -> Solid {
        self.polygon.clone().unwrap_or_else(|| self.circle())
    }

    /// Returns the circle around it. Loose things meet this circle instead of a polygon.
    pub(crate) fn circle(&self) -> Solid {
        Solid::new(&Outline::Circle {
            center: self.center.into(),
            radius: self.radius,
        })
    }

    /// Returns the gap to a solid in metres. It is negative on overlap.
    pub(crate) fn gap_to(&self, solid: &Solid) -> f64 {
        match &self.polygon {
            None => solid.distance_to_point(self.center) - self.radius,
            Some(polygon) => polygon.gap_to_solid(solid),
        }
    }

    /// Returns the gap to another body in metres. It is negative on overlap. Both bodies get the same value,
    /// to the bit, so that one cannot find itself inside the other.
    pub(crate) fn gap_to_body(&self, other: &Self) -> f64 {
        match (&self.polygon, &other.polygon) {
            (None, None) => self.center.distance(other.center) - other.radius - self.radius,
            (Some(one), None) => one.gap_to_solid(&other.circle()),
            (None, Some(two)) => two.gap_to_solid(&self.circle()),
            (Some(one), Some(two)) => {
                let is_first = (self.center.x, self.center.y) <= (other.center.x, other.center.y);
                let (one, two) = if is_first { (one, two) } else { (two, one) };
                one.gap_to_solid(two)
            }
        }
    }

    /// Returns the point of a solid nearest to the body, if the gap is smaller than `reach` metres.
    pub(crate) fn contact(&self, solid: &Solid, reach: f64) -> Option<Vector> {
        match &self.polygon {
            None => {
                let point = solid.nearest(self.center);
                (point.distance(self.center) < self.radius + reach).then_some(point)
            }
            Some(polygon) => polygon.contact(solid, reach),
        }
    }
}

/// Returns the sides of a polygon, from corner to corner.
fn sides_of(corners: &[Vector]) -> impl Iterator<Item = [Vector; 2]> {
    let next = corners.iter().cycle().skip(1);
    corners.iter().zip(next).map(|(from, to)| [*from, *to])
}
