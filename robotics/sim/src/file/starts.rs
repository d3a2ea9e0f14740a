//! The starts of robots, and the bounds of a world.
//!
//! This module does not check whether a start is free: that needs the whole scene.

use std::ops::Range;

use jde_document::section::expect;
use jde_document::{FaultReport, Node, Section, Text, quote};

use super::Start;
use super::values;
use crate::geometry::{Bounds, Pose2};

/// The keys of a pose.
pub(crate) const POSE_KEYS: [&str; 3] = ["x", "y", "heading_deg"];

pub(crate) fn bounds(report: &mut FaultReport<'_>, root: &Section<'_>) -> Option<Option<Bounds>> {
    if root.get("bounds").is_none() {
        return Some(None);
    }
    let table = root.nested(report, "bounds", &["min", "max"])?;
    let (min, max) = (
        table.required(report, "min", values::point),
        table.required(report, "max", values::point),
    );
    let bounds = Bounds { min: min?, max: max? };
    if bounds.min[0] < bounds.max[0] && bounds.min[1] < bounds.max[1] {
        Some(Some(bounds))
    } else {
        table.fault(report, &table.span, "have a `min` that is not less than `max`");
        None
    }
}

pub(crate) fn starts(report: &mut FaultReport<'_>, root: &Section<'_>) -> Option<Vec<(Start, Range<usize>)>> {
    if root.get("robots").is_none() {
        return Some(Vec::new());
    }
    let robots = root.section(report, "robots", "the robots")?;
    let starts: Vec<_> = robots
        .entries()
        .map(|(name, node)| start(report, &name, node))
        .collect();
    starts.into_iter().collect()
}

/// Reads a place in metres and a heading in degrees.
pub(crate) fn pose(report: &mut FaultReport<'_>, table: &Section<'_>) -> Option<Pose2> {
    let (x, y) = (
        table.required(report, "x", values::number),
        table.required(report, "y", values::number),
    );
    let heading = table.optional(report, "heading_deg", 0.0, values::number);
    Some(Pose2::new(x?, y?, heading?.to_radians()))
}

fn start(report: &mut FaultReport<'_>, name: &Text<'_>, node: &Node<'_>) -> Option<(Start, Range<usize>)> {
    const EXAMPLE: &str = "write `start = { x = 0, y = 0, heading_deg = 0 }`";
    let what = format!("robot {}", quote(name.text));
    let entries = expect(
        report,
        &what,
        "a table with a start",
        node,
        node.get_ref().as_table(),
    )?;
    let table = Section::new(what, name.span.clone(), entries);
    table.refuse_unknown(report, &["start"]);
    if table.get("start").is_none() {
        table.fault(report, &table.span, "has no `start`").advise(EXAMPLE);
        return None;
    }
    let table = table.nested(report, "start", &POSE_KEYS)?;
    let pose = pose(report, &table)?;
    let line = report.line(table.span.start);
    let start = Start {
        robot: name.text.to_owned(),
        pose,
        source: format!("{}:{line}", report.file().display()),
    };
    Some((start, table.span))
}
