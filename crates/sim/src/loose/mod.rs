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
pub(crate) const SKIN: f64 = 1e-6;

/// The rounding of a gap that does not change, in metres: a body that slides along a wall does not approach
/// it.
const ROUNDING: f64 = 1e-12;

#[derive(Clone, Copy, Debug)]
pub(crate) enum Form {
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
pub(crate) struct Body {
    pub(crate) name: String,
    pub(crate) form: Form,
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
pub(crate) struct Loose {
    bodies: Vec<Body>,
}

/// The things that loose things cannot move: walls, movers, robots.
pub(crate) trait Firm {
    /// Returns the nearest point within `reach` of a solid, and the gap to the solid; `None` beyond.
    fn nearest(&self, solid: &Solid, center: Vector, reach: f64) -> Option<(Vector, f64)>;

    /// Returns the gap to a solid within `reach`; infinite beyond.
    fn gap(&self, solid: &Solid, center: Vector, reach: f64) -> f64 {
        self.nearest(solid, center, reach)
            .map_or(f64::INFINITY, |(_, gap)| gap)
    }
}

impl Body {
    pub(crate) fn new(name: String, form: Form, center: [f64; 2], mass: f64, color: Color) -> Self {
        Self {
            name,
            form,
            mass,
            color,
            center: Vector::from(center),
            velocity: Vector::ZERO,
            solid: Solid::new(&outline(form, Vector::from(center))),
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
        matches!(self.form, Form::Ball { .. })
    }

    pub(crate) fn shape(&self) -> Shape<'_> {
        Shape {
            name: &self.name,
            outline: outline(self.form, self.center),
            color: self.color,
            height: match self.form {
                Form::Ball { radius } => 2.0 * radius,
                Form::Box { height, .. } => height,
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
    fn moved(&self, way: Vector) -> Solid {
        Solid::new(&outline(self.form, self.center + way))
    }

    fn go(&mut self, way: Vector) {
        self.center += way;
        self.solid = Solid::new(&outline(self.form, self.center));
    }
}

impl Loose {
    pub(crate) fn new(bodies: Vec<Body>) -> Self {
        Self { bodies }
    }

    pub(crate) fn bodies(&self) -> &[Body] {
        &self.bodies
    }

    /// Returns whether a moving solid would enter a thing. Motion away from a thing, or along it, is always
    /// allowed.
    pub(crate) fn hinder(&self, now: &Solid, next: &Solid) -> bool {
        self.bodies.iter().any(|body| {
            enters(body.solid.distance_to_solid(next), || {
                body.solid.distance_to_solid(now)
            })
        })
    }
}

/// Returns whether a gap is too small and smaller than before.
fn enters(gap: f64, before: impl FnOnce() -> f64) -> bool {
    gap <= 0.0 || (gap < SKIN && gap < before() - ROUNDING)
}

fn outline(form: Form, center: Vector) -> Outline {
    let center = center.into();
    match form {
        Form::Ball { radius } => Outline::Circle { center, radius },
        Form::Box { size, angle, .. } => Outline::Box { center, size, angle },
    }
}

#[cfg(test)]
mod tests;
