//! The outline of a robot on the floor. A footprint that does not enclose an area, or that is not convex, is
//! refused.

use jde_types::{Footprint, Point2D, Pose2D};

/// Points of a footprint: as many as the value holds.
const CAPACITY: usize = 32;

/// The outline of a robot: a circle around the origin of the base, or a convex polygon.
#[derive(Clone, Debug, PartialEq)]
pub struct Outline {
    /// Counter-clockwise; none for a circle.
    corners: [Corner; CAPACITY],
    count: usize,
    /// Of the circle, m; 0 for a polygon.
    radius: f64,
    /// Distance from the origin to the farthest corner, m.
    swing: f64,
}

/// A corner of the polygon, and the edge to the next one.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Corner {
    x: f64,
    y: f64,
    /// Direction of the edge, of length 1.
    along: (f64, f64),
    /// Length of the edge, m.
    length: f64,
}

/// Why a footprint is refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum FootprintError {
    /// A number is not finite, or the radius is negative.
    #[error("the footprint's radius and points must be finite numbers, and the radius not negative")]
    NotFinite,
    /// It encloses no area.
    #[error("the footprint needs a radius above 0, or at least three points")]
    Empty,
    /// Its points do not go once around a convex polygon.
    #[error("the footprint's points must go once around a convex polygon, without repeating a point")]
    NotConvex,
}

impl TryFrom<&Footprint> for Outline {
    type Error = FootprintError;

    fn try_from(footprint: &Footprint) -> Result<Self, FootprintError> {
        let points = footprint.points.as_slice();
        let finite = points
            .iter()
            .all(|point| point.x.is_finite() && point.y.is_finite());
        if !finite || !footprint.radius.is_finite() || footprint.radius < 0.0 {
            return Err(FootprintError::NotFinite);
        }
        match points.len() {
            0 if footprint.radius > 0.0 => Ok(Self::circle(footprint.radius)),
            0..3 => Err(FootprintError::Empty),
            3.. => Self::polygon(points),
        }
    }
}

impl Outline {
    fn circle(radius: f64) -> Self {
        Self {
            corners: [Corner::default(); CAPACITY],
            count: 0,
            radius,
            swing: 0.0,
        }
    }

    fn polygon(points: &[Point2D]) -> Result<Self, FootprintError> {
        let count = points.len();
        let twice_the_area: f64 = (0..count)
            .map(|i| (points[i], points[(i + 1) % count]))
            .map(|(a, b)| a.x * b.y - b.x * a.y)
            .sum();
        let mut outline = Self {
            count,
            ..Self::circle(0.0)
        };
        for i in 0..count {
            let order = |i: usize| if twice_the_area < 0.0 { count - 1 - i } else { i };
            let (a, b) = (points[order(i)], points[order((i + 1) % count)]);
            let length = libm::hypot(b.x - a.x, b.y - a.y);
            if length == 0.0 {
                return Err(FootprintError::NotConvex);
            }
            outline.corners[i] = Corner {
                x: a.x,
                y: a.y,
                along: ((b.x - a.x) / length, (b.y - a.y) / length),
                length,
            };
            outline.swing = outline.swing.max(libm::hypot(a.x, a.y));
        }
        // A star also turns left at each corner, so each edge is compared with every corner. The tolerance is
        // far above rounding and far below what a person can measure.
        let tolerance = 1e-9 * outline.swing;
        let convex = outline.corners().iter().all(|edge| {
            outline
                .corners()
                .iter()
                .all(|corner| edge.outside(corner.x, corner.y) <= tolerance)
        });
        if convex && twice_the_area.abs() > tolerance * outline.swing {
            Ok(outline)
        } else {
            Err(FootprintError::NotConvex)
        }
    }

    fn corners(&self) -> &[Corner] {
        &self.corners[..self.count]
    }

    /// Returns the radius of the smallest circle around the base's origin that contains the outline, m.
    #[must_use]
    pub fn reach(&self) -> f64 {
        self.swing + self.radius
    }

    /// Returns the distance that the outline's fastest point moves for a turn of 1 rad about the base's
    /// origin, m: 0 for a circle.
    #[must_use]
    pub fn swing(&self) -> f64 {
        self.swing
    }

    /// Returns discs that cover the outline together, by their middle and radius, m: one for a circle, and
    /// up to eight for a polygon, side by side along its longer extent in x or y. They exceed it by little if
    /// that is the direction in which it is long.
    pub fn discs(&self) -> impl Iterator<Item = (Point2D, f64)> + '_ {
        let extent = |at: fn(&Corner) -> f64| {
            let values = self.corners().iter().map(at);
            values.fold((f64::MAX, f64::MIN), |(low, high), value| {
                (low.min(value), high.max(value))
            })
        };
        let (along, across) = (extent(|corner| corner.x), extent(|corner| corner.y));
        let is_along_x = along.1 - along.0 >= across.1 - across.0;
        let (long, wide) = if is_along_x {
            (along, across)
        } else {
            (across, along)
        };
        let (length, width) = (long.1 - long.0, wide.1 - wide.0);
        // Twice as many as squares: the discs are then wider than the outline by an eighth.
        let count = if self.count == 0 {
            1
        } else {
            ((2.0 * length / width).ceil() as u32).clamp(1, 8)
        };
        (0..count).map(move |at| {
            if self.count == 0 {
                return (Point2D::default(), self.radius);
            }
            let part = length / f64::from(count);
            let (middle, aside) = (
                long.0 + part * (f64::from(at) + 0.5),
                f64::midpoint(wide.0, wide.1),
            );
            let (x, y) = if is_along_x {
                (middle, aside)
            } else {
                (aside, middle)
            };
            (Point2D { x, y }, libm::hypot(part / 2.0, width / 2.0))
        })
    }

    /// Returns the distance from the outline to a point in the frame of the base, m; negative if the point
    /// is inside. Inside, the amount is at most the true depth.
    #[must_use]
    pub fn distance(&self, x: f64, y: f64) -> f64 {
        if self.count == 0 {
            return libm::hypot(x, y) - self.radius;
        }
        let mut outside = f64::NEG_INFINITY;
        let mut nearest = f64::INFINITY;
        for edge in self.corners() {
            outside = outside.max(edge.outside(x, y));
            nearest = nearest.min(edge.squared_distance(x, y));
        }
        if outside <= 0.0 { outside } else { nearest.sqrt() }
    }

    /// Returns the distance from the outline at `pose` to the nearest of `points`, m; +∞ without points. Pose
    /// and points are in one frame.
    #[must_use]
    pub fn clearance(&self, pose: &Pose2D, points: &[Point2D]) -> f64 {
        let middle = least_squared_distance(pose, points).sqrt();
        if self.count == 0 || middle == f64::INFINITY {
            return middle - self.radius;
        }
        let (sin, cos) = libm::sincos(pose.theta);
        let mut least = f64::INFINITY;
        // Squared distance from the pose beyond which a point cannot be the nearest.
        let mut bound = (middle + self.reach()).powi(2);
        for point in points {
            let (dx, dy) = (point.x - pose.x, point.y - pose.y);
            if dx * dx + dy * dy > bound {
                continue;
            }
            let distance = self.distance(cos * dx + sin * dy, cos * dy - sin * dx);
            if distance < least {
                least = distance;
                bound = bound.min((distance + self.reach()).max(0.0).powi(2));
            }
        }
        least
    }
}

/// Returns the least squared distance from the pose to a point, m². Four independent minima let the compiler
/// use the vector unit.
fn least_squared_distance(pose: &Pose2D, points: &[Point2D]) -> f64 {
    let squared = |point: &Point2D| {
        let (dx, dy) = (point.x - pose.x, point.y - pose.y);
        dx * dx + dy * dy
    };
    let mut least = [f64::INFINITY; 4];
    let (fours, rest) = points.as_chunks::<4>();
    for four in fours {
        for (least, point) in least.iter_mut().zip(four) {
            *least = least.min(squared(point));
        }
    }
    rest.iter()
        .map(squared)
        .chain(least)
        .fold(f64::INFINITY, f64::min)
}

impl Corner {
    /// How far a point is to the right of the edge's line, which is outside, m.
    fn outside(&self, x: f64, y: f64) -> f64 {
        self.along.1 * (x - self.x) - self.along.0 * (y - self.y)
    }

    fn squared_distance(&self, x: f64, y: f64) -> f64 {
        let (dx, dy) = (x - self.x, y - self.y);
        let along = (dx * self.along.0 + dy * self.along.1).clamp(0.0, self.length);
        let (dx, dy) = (dx - along * self.along.0, dy - along * self.along.1);
        dx * dx + dy * dy
    }
}

#[cfg(test)]
mod tests;
