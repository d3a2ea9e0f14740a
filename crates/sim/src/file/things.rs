//! The things of a world file: walls, boxes, circles and movers.
//!
//! Each reader reports every fault of its things, and gives nothing if there was one.

use std::ops::Range;

use super::document::{Document, Table};
use super::values;
use crate::mover::{self, AtEnd, Body};
use crate::scene::Fixture;
use crate::shape::Outline;

/// The gap in metres that a mover keeps to robots unless it says otherwise: an arm's length.
const CLEARANCE: f64 = 0.5;
/// How long a mover waits for a robot before it turns back, in seconds, unless it says otherwise.
const WAIT: f64 = 3.0;

pub(crate) fn fixtures(document: &Document<'_>, root: &Table<'_>) -> Option<Vec<Fixture>> {
    let walls = each(
        document,
        root,
        "walls",
        "wall",
        &["name", "points", "closed"],
        wall,
    );
    let boxes = each(
        document,
        root,
        "boxes",
        "box",
        &["name", "center", "size", "angle_deg"],
        rectangle,
    );
    let circles = each(
        document,
        root,
        "circles",
        "circle",
        &["name", "center", "radius"],
        circle,
    );
    Some(
        walls?
            .into_iter()
            .chain(boxes?)
            .chain(circles?)
            .flatten()
            .collect(),
    )
}

pub(crate) fn movers(document: &Document<'_>, root: &Table<'_>) -> Option<Vec<(mover::Plan, Range<usize>)>> {
    let known = [
        "name",
        "radius",
        "size",
        "way",
        "speed",
        "loop",
        "clearance",
        "wait",
    ];
    each(document, root, "movers", "mover", &known, |table, name| {
        Some((mover(table, name)?, table.span().clone()))
    })
}

/// Reads every item of an array of tables, each with its name; nothing if any has a fault.
fn each<'a, T>(
    document: &'a Document<'a>,
    root: &Table<'a>,
    key: &str,
    kind: &str,
    known: &[&str],
    read: impl Fn(&Table<'a>, String) -> Option<T>,
) -> Option<Vec<T>> {
    let faulty = root.get(key).is_some_and(|item| !item.get_ref().is_array());
    let things: Vec<_> = (1..)
        .zip(root.array(key))
        .map(|(number, item)| {
            let table = Table::item(document, item, kind, number, known)?;
            let name = table.optional("name", format!("{kind} {number}"), values::text);
            let thing = read(&table, name.clone().unwrap_or_default());
            name.and(thing)
        })
        .collect();
    if faulty {
        None
    } else {
        things.into_iter().collect()
    }
}

fn wall(table: &Table<'_>, name: String) -> Option<Vec<Fixture>> {
    let points = table.required("points", values::points);
    let closed = table.optional("closed", false, values::flag);
    let (mut points, closed) = (points?, closed?);
    if closed {
        if points.len() < 3 {
            table.fault(
                table.span(),
                "is `closed` with two points: expected three or more",
            );
            return None;
        }
        if points[0] == points[points.len() - 1] {
            table.fault(
                table.span(),
                "is `closed` and ends where it starts: drop the last point",
            );
            return None;
        }
        points.push(points[0]);
    }
    let sides = points.windows(2).map(|pair| Outline::Segment {
        from: pair[0],
        to: pair[1],
    });
    Some(
        sides
            .map(|outline| Fixture {
                name: name.clone(),
                outline,
            })
            .collect(),
    )
}

fn rectangle(table: &Table<'_>, name: String) -> Option<Vec<Fixture>> {
    let (center, size) = (
        table.required("center", values::point),
        table.required("size", values::size),
    );
    let angle = table.optional("angle_deg", 0.0, values::number);
    let outline = Outline::Box {
        center: center?,
        size: size?,
        angle: angle?.to_radians(),
    };
    Some(vec![Fixture { name, outline }])
}

fn circle(table: &Table<'_>, name: String) -> Option<Vec<Fixture>> {
    let (center, radius) = (
        table.required("center", values::point),
        table.required("radius", values::positive),
    );
    Some(vec![Fixture {
        name,
        outline: Outline::Circle {
            center: center?,
            radius: radius?,
        },
    }])
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
    let way = table.required("way", values::points);
    let speed = table.required("speed", values::positive);
    let closed = table.optional("loop", false, values::flag);
    let clearance = table.optional("clearance", CLEARANCE, values::positive);
    let patience = table.optional("wait", WAIT, values::not_negative);
    let (way, at_end) = (way?, if closed? { AtEnd::Loop } else { AtEnd::TurnBack });
    if at_end == AtEnd::Loop && way[0] == way[way.len() - 1] {
        table.fault(
            table.span(),
            "is a `loop` whose `way` ends where it starts: drop the last point",
        );
        return None;
    }
    Some(mover::Plan {
        name,
        body: body?,
        way,
        at_end,
        speed: speed?,
        clearance: clearance?,
        patience: patience?,
    })
}
