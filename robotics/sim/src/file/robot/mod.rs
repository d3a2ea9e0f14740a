//! Robot files: TOML with the footprint, the drive, the odometry and the sensors of a robot, in metres,
//! degrees and seconds.
//!
//! The faults of a file are reported together. The reader ignores nothing.

mod drive;
mod sensors;

use std::path::Path;

use super::document::{Document, Item, Table};
use super::parse;
use super::values::{self, Read, between};
use crate::config::RobotConfig;
use crate::error::Fault;
use crate::footprint::{Footprint, Polygon};
use crate::model::RobotModel;

const KEYS: [&str; 13] = [
    "name",
    "doc",
    "footprint",
    "drive",
    "odometry",
    "lasers",
    "sonars",
    "line_sensor",
    "imu",
    "position",
    "bumpers",
    "head",
    "battery",
];

pub(crate) fn read(text: &str, path: &Path) -> Result<RobotModel, Vec<Fault>> {
    parse(text, path, "robot", &KEYS, robot)
}

/// Reads all parts before it returns, so that every fault is reported.
fn robot(document: &Document<'_>, root: &Table<'_>) -> Option<RobotModel> {
    let stem = document.path().file_stem().unwrap_or_default();
    let name = root.optional("name", stem.to_string_lossy().into_owned(), values::text);
    let doc = root.optional("doc", String::new(), values::text);
    let footprint =
        section(document, root, "footprint", &["radius", "polygon"]).and_then(|table| footprint(&table));
    let wheels = drive::odometry(document, root);
    let config = drive::read(document, root, wheels);
    let lasers = sensors::lasers(document, root);
    let sonars = sensors::sonars(document, root);
    let line_sensor = sensors::line(document, root);
    let imu = sensors::imu(document, root);
    let position = sensors::position(document, root);
    let bumpers = root.optional("bumpers", false, values::flag);
    let battery = root.optional("battery", false, values::flag);
    let head = sensors::head(document, root)?;
    Some(RobotModel {
        name: name?,
        doc: doc?,
        config: RobotConfig {
            footprint: footprint?,
            head: head.clone().unwrap_or_default(),
            ..config?
        },
        lasers: lasers?,
        sonars: sonars?,
        line_sensor: line_sensor?,
        imu: imu?,
        position: position?,
        bumpers: bumpers?,
        head: head.is_some(),
        battery: battery?,
    })
}

fn footprint(table: &Table<'_>) -> Option<Footprint> {
    match (table.get("radius"), table.get("polygon")) {
        (Some(_), None) => {
            let radius = table.required("radius", between(0.01, 10.0, "m"))?;
            Some(Footprint::Circle { radius })
        }
        (None, Some(_)) => table.required("polygon", polygon).map(Footprint::Polygon),
        (Some(_), Some(_)) | (None, None) => {
            table.fault(table.span(), "expected either a `radius` or a `polygon`");
            None
        }
    }
}

fn polygon(item: &Item<'_>) -> Read<Polygon> {
    Polygon::new(&values::points(item)?).map_err(|reason| (item.span(), reason))
}

/// Returns a table of the file; a missing one is a fault.
fn section<'a>(document: &'a Document<'a>, root: &Table<'a>, key: &str, known: &[&str]) -> Option<Table<'a>> {
    let Some(item) = root.get(key) else {
        root.fault(
            root.span(),
            format!("[{key}] is missing: expected `{}`", known.join("`, `")),
        );
        return None;
    };
    Table::nested(document, item, key, known)
}

/// Returns a reader of degrees, which returns radians.
fn degrees(low: f64, high: f64, unit: &'static str) -> impl Fn(&Item<'_>) -> Read<f64> {
    move |item| Ok(between(low, high, unit)(item)?.to_radians())
}
