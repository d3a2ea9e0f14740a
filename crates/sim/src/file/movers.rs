//! The things of a world file that move on their own: movers and people.
//!
//! Each reader reports every fault of its things, and returns `None` if there is one.

use std::ops::Range;

use super::document::{Document, Table};
use super::things::{self, Look, each};
use super::values;
use crate::color::Color;
use crate::mover::{self, AtEnd, Body};

/// The default clearance of a mover to robots, in metres: an arm's length.
const CLEARANCE: f64 = 0.5;
/// The default time that a mover waits before it turns back, in seconds.
const WAIT: f64 = 3.0;

/// The default look of movers: a painted cart.
const MOVER: Look = Look {
    color: Color::new(74, 116, 168),
    height: 1.0,
};
/// The default look of people: the colour of their clothing, and their height.
const PERSON: Look = Look {
    color: Color::new(46, 86, 140),
    height: 1.72,
};
/// The default radius of a person, in metres.
const SHOULDERS: f64 = 0.25;

pub(crate) fn read(document: &Document<'_>, root: &Table<'_>) -> Option<Vec<(mover::Plan, Range<usize>)>> {
    let known = [
        "name",
        "color",
        "height",
        "radius",
        "size",
        "way",
        "speed",
        "loop",
        "clearance",
        "wait",
    ];
    let movers = each(document, root, "movers", "mover", &known, |table, name| {
        Some((mover(table, name)?, table.span().clone()))
    });
    let known = [
        "name",
        "color",
        "height",
        "radius",
        "way",
        "speed",
        "pause",
        "loop",
        "clearance",
        "wait",
    ];
    let people = each(document, root, "people", "person", &known, |table, name| {
        Some((person(table, name)?, table.span().clone()))
    });
    Some(movers?.into_iter().chain(people?).collect())
}

fn mover(table: &Table<'_>, name: String) -> Option<mover::Plan> {
    let body = match (table.get("radius"), table.get("size")) {
        (Some(_), None) => table
            .required("radius", values::positive)
            .map(|radius| Body::Circle { radius }),
        (None, Some(_)) => table
            .required("size", values::size)
            .map(|size| Body::Box { size }),
        (Some(_), Some(_)) | (None, None) => {
            table.fault(
                table.span(),
                "needs a `radius` for a round body or a `size` for a box, and only one",
            );
            None
        }
    };
    let look = things::look(table, MOVER);
    walk(table, name, body, look, 0.0)
}

fn person(table: &Table<'_>, name: String) -> Option<mover::Plan> {
    let radius = table.optional("radius", SHOULDERS, values::positive);
    let look = things::look(table, PERSON);
    let pause = table.optional("pause", 0.0, values::not_negative);
    let body = radius.map(|radius| Body::Person { radius });
    walk(table, name, body, look, pause?)
}

/// Reads the keys that movers and people share.
fn walk(
    table: &Table<'_>,
    name: String,
    body: Option<Body>,
    look: Option<Look>,
    pause: f64,
) -> Option<mover::Plan> {
    let way = table.required("way", values::points);
    let speed = table.required("speed", values::speed);
    let closed = table.optional("loop", false, values::flag);
    let clearance = table.optional("clearance", CLEARANCE, values::positive);
    let patience = table.optional("wait", WAIT, values::not_negative);
    let (way, at_end) = (way?, if closed? { AtEnd::Loop } else { AtEnd::TurnBack });
    if at_end == AtEnd::Loop && !values::apart(way[way.len() - 1], way[0]) {
        table.fault(
            table.span(),
            "is a `loop` whose `way` ends where it starts: drop the last point",
        );
        return None;
    }
    let Look { color, height } = look?;
    Some(mover::Plan {
        name,
        body: body?,
        way,
        at_end,
        speed: speed?,
        clearance: clearance?,
        patience: patience?,
        pause,
        color,
        height,
    })
}
