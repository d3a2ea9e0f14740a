//! The things of a world file that can be pushed: balls, and boxes that are movable.
//!
//! Each reader reports every fault of its things, and returns `None` if there is one. `room` checks their
//! places.

use std::ops::Range;

use super::fixtures::{self, Appearance, BOX, each};
use super::values;
use crate::color::Color;
use crate::loose::{LooseBody, LooseShape};
use jde_document::{FaultReport, Section};

/// A loose thing, and its span in the file.
pub(crate) type PlacedBody = (LooseBody, Range<usize>);

/// The default mass of a box in kilograms: a carton that is half full.
const BOX_MASS: f64 = 4.0;
/// The default mass of a ball in kilograms: a football.
const BALL_MASS: f64 = 0.43;
/// The default colour of a ball.
const BALL: Color = Color::new(240, 124, 24);

pub(crate) fn balls(report: &mut FaultReport<'_>, root: &Section<'_>) -> Option<Vec<PlacedBody>> {
    let known = ["name", "center", "radius", "color", "mass"];
    each(report, root, "balls", "ball", &known, ball)
}

/// Reads a box that is `movable`.
pub(crate) fn movable(report: &mut FaultReport<'_>, table: &Section<'_>, name: String) -> Option<LooseBody> {
    for key in ["reflectivity", "surface", "legs"] {
        if let Some(node) = table.get(key) {
            let message = format!("has `{key}` and is `movable`: drop one");
            table.fault(report, &node.span(), message);
            return None;
        }
    }
    let rectangle = fixtures::rectangle(report, table);
    let (appearance, mass) = (
        fixtures::read_appearance(report, table, BOX),
        table.optional(report, "mass", BOX_MASS, values::positive),
    );
    let ((center, size, angle), Appearance { color, height }) = (rectangle?, appearance?);
    let form = LooseShape::Box { size, angle, height };
    Some(LooseBody::new(name, form, center, mass?, color))
}

fn ball(report: &mut FaultReport<'_>, table: &Section<'_>, name: String) -> Option<PlacedBody> {
    let (center, radius) = (
        table.required(report, "center", values::point),
        table.required(report, "radius", values::positive),
    );
    let color = table.optional(report, "color", BALL, values::color);
    let mass = table.optional(report, "mass", BALL_MASS, values::positive);
    let form = LooseShape::Ball { radius: radius? };
    Some((
        LooseBody::new(name, form, center?, mass?, color?),
        table.span.clone(),
    ))
}
