//! The starts of robots, and the bounds of a world.
//!
//! This module does not check whether a start is free: that needs the whole scene.

use std::ops::Range;

use super::Start;
use super::document::{Document, Item, Table};
use super::values;
use crate::geometry::{Bounds, Pose2};

/// The keys of a pose.
pub(crate) const POSE_KEYS: [&str; 3] = ["x", "y", "heading_deg"];

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
        table.required("min", values::point),
        table.required("max", values::point),
    );
    let bounds = Bounds { min: min?, max: max? };
    if bounds.min[0] < bounds.max[0] && bounds.min[1] < bounds.max[1] {
        Some(Some(bounds))
    } else {
        table.fault(table.span(), "`min` is not less than `max`");
        None
    }
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

/// Reads a place in metres and a heading in degrees.
pub(crate) fn pose(table: &Table<'_>) -> Option<Pose2> {
    let (x, y) = (
        table.required("x", values::number),
        table.required("y", values::number),
    );
    let heading = table.optional("heading_deg", 0.0, values::number);
    Some(Pose2::new(x?, y?, heading?.to_radians()))
}

fn start<'a>(
    document: &'a Document<'a>,
    name: &str,
    span: Range<usize>,
    robot: &'a Item<'a>,
) -> Option<(Start, Range<usize>)> {
    let what = format!("robot `{name}`");
    let Some(keys) = robot.get_ref().as_table() else {
        document.fault(&robot.span(), format!("{what}: expected a table with a start"));
        return None;
    };
    let table = Table::new(document, keys, span, what.clone(), &["start"]);
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
        &POSE_KEYS,
    );
    let pose = pose(&table)?;
    let line = document.line(table.span());
    Some((
        Start {
            robot: name.to_owned(),
            pose,
            source: format!("{}:{line}", document.path().display()),
        },
        item.span(),
    ))
}
