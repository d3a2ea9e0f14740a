//! Robot files: TOML with the footprint, the drive, the odometry and the sensors of a robot, in metres,
//! degrees and seconds.
//!
//! The faults of a file are reported together. The reader ignores nothing.

mod drive;
mod lasers;
mod physics;
mod sensors;

use std::path::Path;

use super::parse;
use super::values::{self, between};
use crate::config::RobotConfig;
use crate::footprint::{Footprint, Polygon};
use crate::model::RobotModel;
use jde_document::{Checked, FaultReport, Faults, Node, Section, WrongValue, quote_all};

const KEYS: [&str; 14] = [
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
    "physics",
];

pub(crate) fn read(text: &str, path: &Path) -> Result<RobotModel, Faults> {
    parse(text, path, "robot", &KEYS, robot)
}

/// Reads all parts before it returns, so that every fault is reported.
fn robot(report: &mut FaultReport<'_>, root: &Section<'_>) -> Option<RobotModel> {
    let stem = report.file().file_stem().unwrap_or_default();
    let name = root.optional(report, "name", stem.to_string_lossy().into_owned(), values::text);
    let doc = root.optional(report, "doc", String::new(), values::text);
    let footprint = section(report, root, "footprint", &["radius", "polygon"])
        .and_then(|table| footprint(report, &table));
    let (wheels, odometry) = drive::odometry(report, root).unzip();
    let config = drive::read(report, root, wheels);
    let lasers = lasers::read(report, root);
    let sonars = sensors::sonars(report, root);
    let line_sensor = sensors::line(report, root);
    let imu = sensors::imu(report, root);
    let position = sensors::position(report, root);
    let bumpers = root.optional(report, "bumpers", false, values::flag);
    let battery = root.optional(report, "battery", false, values::flag);
    let physics = physics::read(report, root);
    let head = sensors::head(report, root)?;
    let lasers = lasers?;
    let turns = lasers.iter().filter_map(|laser| laser.config.turn);
    Some(RobotModel {
        name: name?,
        doc: doc?,
        config: RobotConfig {
            footprint: footprint?,
            head: head.clone().unwrap_or_default(),
            trail: turns.map(|turn| turn.period).fold(0.0, f64::max),
            ..config?
        },
        odometry: odometry?,
        lasers,
        sonars: sonars?,
        line_sensor: line_sensor?,
        imu: imu?,
        position: position?,
        bumpers: bumpers?,
        head: head.is_some(),
        battery: battery?,
        physics: physics?,
    })
}

fn footprint(report: &mut FaultReport<'_>, table: &Section<'_>) -> Option<Footprint> {
    match (table.get("radius"), table.get("polygon")) {
        (Some(_), None) => {
            let radius = table.required(report, "radius", between(0.01, 10.0, "m"))?;
            Some(Footprint::Circle { radius })
        }
        (None, Some(_)) => table.required(report, "polygon", polygon).map(Footprint::Polygon),
        (Some(_), Some(_)) | (None, None) => {
            table.fault(report, &table.span, "must have either a `radius` or a `polygon`");
            None
        }
    }
}

fn polygon(node: &Node<'_>) -> Checked<Polygon> {
    Polygon::new(&values::points(node)?).map_err(|reason| WrongValue::new(node, reason))
}

/// Returns a table of the file; a missing one is a fault.
fn section<'a>(
    report: &mut FaultReport<'_>,
    root: &Section<'a>,
    key: &str,
    known: &[&str],
) -> Option<Section<'a>> {
    if root.get(key).is_none() {
        report
            .file_fault(format!("{} is missing", root.key(key)))
            .advise(format!("add [{key}] with {}", quote_all(known.iter().copied())));
        return None;
    }
    root.nested(report, key, known)
}

/// Returns a reader of degrees, which returns radians.
fn degrees(low: f64, high: f64, unit: &'static str) -> impl Fn(&Node<'_>) -> Checked<f64> {
    move |node| Ok(between(low, high, unit)(node)?.to_radians())
}
