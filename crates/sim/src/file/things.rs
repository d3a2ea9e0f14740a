//! The things of a world file: walls, boxes, circles, movers, starts and bounds.
//!
//! Each reader reports every fault of its things, and gives nothing if there was one.

use std::ops::Range;

use super::Start;
use super::document::{self, Document, Item, Table};
use crate::geometry::{Bounds, Pose2};
use crate::mover::{self, AtEnd, Body};
use crate::scene::Fixture;
use crate::shape::Outline;

/// The gap in metres that a mover keeps to robots unless it says otherwise: an arm's length.
const CLEARANCE: f64 = 0.5;
/// How long a mover waits for a robot before it turns back, in seconds, unless it says otherwise.
const WAIT: f64 = 3.0;

pub(crate) fn bounds(document: &Document<'_>, root: &Table<'_>) -> Option<Option<Bounds>> {
    let Some(item) = root.get("bounds") else {
        return Some(None);
    };
    let Some(keys) = item.get_ref().as_table() else {
        root.fault(
            &item.span(),
            "`bounds` is not a table: expected { min = [x, y], max = [x, y] }",
        );
        return None;
    };
    let table = Table::new(document, keys, item.span(), "bounds".to_owned(), &["min", "max"]);
    let (min, max) = (
        table.required("min", document::point),
        table.required("max", document::point),
    );
    let bounds = Bounds { min: min?, max: max? };
    if bounds.min[0] < bounds.max[0] && bounds.min[1] < bounds.max[1] {
        Some(Some(bounds))
    } else {
        table.fault(table.span(), "`min` is not below and left of `max`");
        None
    }
}

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

pub(crate) fn starts(document: &Document<'_>, root: &Table<'_>) -> Option<Vec<(Start, Range<usize>)>> {
    let Some(item) = root.get("robots") else {
        return Some(Vec::new());
    };
    let Some(robots) = item.get_ref().as_table() else {
        root.fault(
            &item.span(),
            "`robots` is not a table: expected [robots.NAME] with a start",
        );
        return None;
    };
    let starts: Vec<_> = robots
        .iter()
        .map(|(name, robot)| start(document, name.get_ref(), name.span(), robot))
        .collect();
    starts.into_iter().collect()
}

fn start<'a>(
    document: &'a Document<'a>,
    name: &str,
    place: Range<usize>,
    robot: &'a Item<'a>,
) -> Option<(Start, Range<usize>)> {
    let what = format!("robot `{name}`");
    let Some(keys) = robot.get_ref().as_table() else {
        document.fault(&robot.span(), format!("{what}: expected a table with a start"));
        return None;
    };
    let table = Table::new(document, keys, place, what.clone(), &["start"]);
    let Some(item) = table.get("start") else {
        table.fault(
            table.span(),
            "`start` is missing: expected { x = 0, y = 0, heading_deg = 0 }",
        );
        return None;
    };
    let Some(keys) = item.get_ref().as_table() else {
        table.fault(
            &item.span(),
            "`start` is not a table: expected { x = 0, y = 0, heading_deg = 0 }",
        );
        return None;
    };
    let table = Table::new(
        document,
        keys,
        item.span(),
        format!("start of {what}"),
        &["x", "y", "heading_deg"],
    );
    let (x, y) = (
        table.required("x", document::number),
        table.required("y", document::number),
    );
    let heading = table.optional("heading_deg", 0.0, document::number);
    let pose = Pose2::new(x?, y?, heading?.to_radians());
    let line = document.line(table.span());
    Some((
        Start {
            robot: name.to_owned(),
            pose,
            file: document.path().to_owned(),
            line,
        },
        item.span(),
    ))
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
            let name = table.optional("name", format!("{kind} {number}"), document::text);
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
    let points = table.required("points", document::points);
    let closed = table.optional("closed", false, document::flag);
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
        table.required("center", document::point),
        table.required("size", document::size),
    );
    let angle = table.optional("angle_deg", 0.0, document::number);
    let outline = Outline::Box {
        center: center?,
        size: size?,
        angle: angle?.to_radians(),
    };
    Some(vec![Fixture { name, outline }])
}

fn circle(table: &Table<'_>, name: String) -> Option<Vec<Fixture>> {
    let (center, radius) = (
        table.required("center", document::point),
        table.required("radius", document::positive),
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
            .required("radius", document::positive)
            .map(|radius| Body::Circle { radius }),
        (None, Some(_)) => table
            .required("size", document::size)
            .map(|size| Body::Box { size }),
        (Some(_), Some(_)) | (None, None) => {
            table.fault(
                table.span(),
                "needs a `radius` for a round body or a `size` for a box, and only one",
            );
            None
        }
    };
    let way = table.required("way", document::points);
    let speed = table.required("speed", document::positive);
    let closed = table.optional("loop", false, document::flag);
    let clearance = table.optional("clearance", CLEARANCE, document::positive);
    let patience = table.optional("wait", WAIT, document::not_negative);
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
