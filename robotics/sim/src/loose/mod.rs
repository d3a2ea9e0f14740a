//! Things that are not fixed and do not move on their own: balls that roll, and boxes that slide when they
//! are pushed.
//!
//! The model is quasi-static. A box moves only while it is pushed, without turning. A ball rolls on and slows
//! down. Nothing ever enters anything else. See `push` for robots that push, and `roll` for balls that roll.

mod push;
mod roll;

pub(crate) use push::Pusher;

use parry2d_f64::math::Vector;

use crate::color::Color;
use crate::shape::{Figure, Outline, Shape};
use crate::solid::Solid;

/// The gap that is kept between bodies in contact, in metres: far above rounding errors, too small to see.
pub(crate) const CONTACT_GAP: f64 = 1e-6;

/// The rounding of a gap that does not change, in metres: a body that slides along a wall does not approach
/// it.
const ROUNDING: f64 = 1e-12;

#[derive(Clone, Copy, Debug)]
pub(crate) enum LooseShape {
    Ball {
        radius: f64,
    },
    Box {
        size: [f64; 2],
        angle: f64,
        /// Its height, in metres.
        height: f64,
    },
}

#[derive(Clone, Debug)]
pub(crate) struct LooseBody {
    pub(crate) name: String,
    pub(crate) form: LooseShape,
    /// Kilograms.
    pub(crate) mass: f64,
    pub(crate) color: Color,
    center: Vector,
    /// Metres a second; always zero for a box.
    velocity: Vector,
    solid: Solid,
}

/// All loose things of a world, in the order of its file.
#[derive(Default)]
pub(crate) struct LooseBodies {
    bodies: Vec<LooseBody>,
}

/// The things that loose things cannot move: walls, movers, robots.
pub(crate) trait Obstacles {
    /// Returns the nearest point within `reach` of a solid, and the gap to the solid; `None` beyond.
    fn nearest(&self, solid: &Solid, center: Vector, reach: f64) -> Option<(Vector, f64)>;

    /// Returns the gap to a solid within `reach`; infinite beyond.
    fn gap(&self, solid: &Solid, center: Vector, reach: f64) -> f64 {
        self.nearest(solid, center, reach)
            .map_or(f64::INFINITY, |(_, gap)| gap)
    }
}

impl LooseBody {
    pub(crate) fn new(name: String, form: LooseShape, center: [f64; 2], mass: f64, color: Color) -> Self {
        Self {
            name,
            form,
            mass,
            color,
            center: Vector::from(center),
            velocity: Vector::ZERO,
            solid: solid(form, Vector::from(center)),
        }
    }

    pub(crate) fn solid(&self) -> &Solid {
        &self.solid
    }

    /// Returns two opposite corners of its bounding box.
    pub(crate) fn corners(&self) -> [[f64; 2]; 2] {
        let area = self.solid.aabb();
        [area.mins.into(), area.maxs.into()]
    }

    pub(crate) fn center(&self) -> [f64; 2] {
        self.center.into()
    }

    pub(crate) fn is_ball(&self) -> bool {
        matches!(self.form, LooseShape::Ball { .. })
    }

    pub(crate) fn shape(&self) -> Shape<'_> {
        Shape {
            name: &self.name,
            outline: outline(self.form, self.center),
            color: self.color,
            height: match self.form {
                LooseShape::Ball { radius } => 2.0 * radius,
                LooseShape::Box { height, .. } => height,
            },
            moving: true,
            figure: if self.is_ball() {
                Figure::Ball
            } else {
                Figure::Upright
            },
        }
    }

    /// Returns its solid after a displacement.
    fn translated(&self, way: Vector) -> Solid {
        solid(self.form, self.center + way)
    }

    fn translate(&mut self, way: Vector) {
        self.center += way;
        self.solid = solid(self.form, self.center);
    }
}

impl LooseBodies {
    pub(crate) fn new(bodies: Vec<LooseBody>) -> Self {
        Self { bodies }
    }

    pub(crate) fn bodies(&self) -> &[LooseBody] {
        &self.bodies
    }

    pub(crate) fn add(&mut self, body: LooseBody) {
        self.bodies.push(body);
    }

    /// Removes all things of a name. Returns whether there was one.
    pub(crate) fn remove(&mut self, name: &str) -> bool {
        let before = self.bodies.len();
        self.bodies.retain(|body| body.name != name);
        self.bodies.len() < before
    }

    /// Returns whether a moving solid would enter a thing. Motion away from a thing, or along it, is always
    /// allowed.
    pub(crate) fn blocks(&self, now: &Solid, next: &Solid) -> bool {
        self.bodies.iter().any(|body| {
            penetrates_more(body.solid.distance_to_solid(next), || {
                body.solid.distance_to_solid(now)
            })
        })
    }
}

/// Returns whether a gap is too small and smaller than before.
fn penetrates_more(gap: f64, before: impl FnOnce() -> f64) -> bool {
    gap <= 0.0 || (gap < CONTACT_GAP && gap < before() - ROUNDING)
}

/// A ball, which cameras follow, is as high as any laser.
fn solid(form: LooseShape, center: Vector) -> Solid {
    let solid = Solid::new(&outline(form, center));
    match form {
        LooseShape::Ball { .. } => solid,
        LooseShape::Box { height, .. } => solid.of_height(height),
    }
}

fn outline(form: LooseShape, center: Vector) -> Outline {
    let center = center.into();
    match form {
        LooseShape::Ball { radius } => Outline::Circle { center, radius },
        LooseShape::Box { size, angle, .. } => Outline::Box { center, size, angle },
    }
}

#[cfg(test)]
mod tests;
