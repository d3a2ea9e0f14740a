//! The things of a world file that can be pushed: balls, and boxes that are movable.
//!
//! Each reader reports every fault of its things, and returns `None` if there is one. `room` checks their
//! places.

use std::ops::Range;

use super::document::{Document, Table};
use super::things::{self, BOX, Look, each};
use super::values;
use crate::color::Color;
use crate::loose::{Body, Form};

/// A loose thing, and its span in the file.
pub(crate) type Placed = (Body, Range<usize>);

/// The default mass of a box in kilograms: a carton that is half full.
const BOX_MASS: f64 = 4.0;
/// The default mass of a ball in kilograms: a football.
const BALL_MASS: f64 = 0.43;
/// The default colour of a ball.
const BALL: Color = Color::new(240, 124, 24);

pub(crate) fn balls(document: &Document<'_>, root: &Table<'_>) -> Option<Vec<Placed>> {
    let known = ["name", "center", "radius", "color", "mass"];
    each(document, root, "balls", "ball", &known, ball)
}

/// Reads a box that is `movable`.
pub(crate) fn movable(table: &Table<'_>, name: String) -> Option<Placed> {
    let place = things::rectangle(table);
    let (look, mass) = (
        things::look(table, BOX),
        table.optional("mass", BOX_MASS, values::positive),
    );
    let ((center, size, angle), Look { color, height }) = (place?, look?);
    let form = Form::Box { size, angle, height };
    Some((Body::new(name, form, center, mass?, color), table.span().clone()))
}

fn ball(table: &Table<'_>, name: String) -> Option<Placed> {
    let (center, radius) = (
        table.required("center", values::point),
        table.required("radius", values::positive),
    );
    let color = table.optional("color", BALL, values::color);
    let mass = table.optional("mass", BALL_MASS, values::positive);
    let form = Form::Ball { radius: radius? };
    Some((
        Body::new(name, form, center?, mass?, color?),
        table.span().clone(),
    ))
}
