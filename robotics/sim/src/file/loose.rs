//! The things of a world file that can be pushed: balls, and boxes that are movable.
//!
//! Each reader reports every fault of its things, and returns `None` if there is one. `room` checks their
//! places.

use std::ops::Range;

use super::document::{Document, Table};
use super::fixtures::{self, Appearance, BOX, each};
use super::values;
use crate::color::Color;
use crate::loose::{LooseBody, LooseShape};

/// A loose thing, and its span in the file.
pub(crate) type PlacedBody = (LooseBody, Range<usize>);

/// The default mass of a box in kilograms: a carton that is half full.
const BOX_MASS: f64 = 4.0;
/// The default mass of a ball in kilograms: a football.
const BALL_MASS: f64 = 0.43;
/// The default colour of a ball.
const BALL: Color = Color::new(240, 124, 24);

pub(crate) fn balls(document: &Document<'_>, root: &Table<'_>) -> Option<Vec<PlacedBody>> {
    let known = ["name", "center", "radius", "color", "mass"];
    each(document, root, "balls", "ball", &known, ball)
}

/// Reads a box that is `movable`.
pub(crate) fn movable(table: &Table<'_>, name: String) -> Option<LooseBody> {
    if let Some(reflectivity) = table.get("reflectivity") {
        table.fault(
            &reflectivity.span(),
            "has a `reflectivity` and is `movable`: drop one",
        );
        return None;
    }
    let rectangle = fixtures::rectangle(table);
    let (appearance, mass) = (
        fixtures::read_appearance(table, BOX),
        table.optional("mass", BOX_MASS, values::positive),
    );
    let ((center, size, angle), Appearance { color, height }) = (rectangle?, appearance?);
    let form = LooseShape::Box { size, angle, height };
    Some(LooseBody::new(name, form, center, mass?, color))
}

fn ball(table: &Table<'_>, name: String) -> Option<PlacedBody> {
    let (center, radius) = (
        table.required("center", values::point),
        table.required("radius", values::positive),
    );
    let color = table.optional("color", BALL, values::color);
    let mass = table.optional("mass", BALL_MASS, values::positive);
    let form = LooseShape::Ball { radius: radius? };
    Some((
        LooseBody::new(name, form, center?, mass?, color?),
        table.span().clone(),
    ))
}
