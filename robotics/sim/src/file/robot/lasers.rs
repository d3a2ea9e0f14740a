//! The lasers of a robot file.

use super::super::fixtures::each;
use super::super::values::{self, between};
use super::degrees;
use super::sensors::{DELIVERY_KEYS, RANGE_KEYS, delivery, mount, range};
use crate::model::LaserModel;
use crate::sensor::{LaserConfig, LaserTurn, NoReturn};
use jde_document::{Checked, FaultReport, Node, Section, WrongValue};

const KEYS: [&str; 9] = [
    "name",
    "mount",
    "height",
    "beams",
    "view_deg",
    "intensity",
    "turning",
    "dropped_beams",
    "no_return",
];

/// Most beams of a laser: more than any has, few enough to fill a scan in milliseconds.
const MAX_BEAMS: f64 = 1e5;

/// The directions in which a laser turns: whether clockwise, as seen from above.
const DIRECTIONS: [(&str, bool); 2] = [("counterclockwise", false), ("clockwise", true)];

const NO_RETURNS: [(&str, NoReturn); 4] = [
    ("inf", NoReturn::Infinity),
    ("max", NoReturn::Max),
    ("zero", NoReturn::Zero),
    ("nan", NoReturn::Nan),
];

pub(super) fn read(report: &mut FaultReport<'_>, root: &Section<'_>) -> Option<Vec<LaserModel>> {
    let keys = [&KEYS[..], &RANGE_KEYS, &DELIVERY_KEYS].concat();
    let mut lasers = each(report, root, "lasers", "laser", &keys, |report, table, name| {
        Some((laser(report, table, name)?, table.span.clone()))
    })?;
    for index in 0..lasers.len() {
        let (earlier, rest) = lasers.split_at_mut(index);
        let (laser, span) = &mut rest[0];
        if earlier.iter().any(|(other, _)| other.name == laser.name) {
            let message = format!("laser `{}` is there twice: give each its own name", laser.name);
            report.fault(span, message);
        }
        laser.config.stream = u16::try_from(index).unwrap_or(u16::MAX);
    }
    Some(lasers.into_iter().map(|(laser, _)| laser).collect())
}

fn laser(report: &mut FaultReport<'_>, table: &Section<'_>, name: String) -> Option<LaserModel> {
    let default = LaserConfig::default();
    let mount = mount(report, table);
    let height = table.optional(report, "height", 0.0, between(0.0, 10.0, "m"));
    let beams = table.required(report, "beams", beams);
    let view = table.required(report, "view_deg", degrees(0.1, 360.0, "degrees"));
    let range = range(report, table, default.range_min, default.sigma);
    let intensity = table.optional(report, "intensity", 0.0, between(0.0, 1e6, ""));
    let dropped = table.optional(report, "dropped_beams", 0.0, between(0.0, 1.0, ""));
    let no_return = table.optional(report, "no_return", NoReturn::Infinity, |node| {
        values::one_of(node, "what a beam reads", &NO_RETURNS)
    });
    let clockwise = table.optional(report, "turning", None, |node| {
        values::one_of(node, "a direction of turning", &DIRECTIONS).map(Some)
    });
    let delivery = delivery(report, table);
    let ((range, period), clockwise) = (range?, clockwise?);
    let turn = match (clockwise, period.map(|period| period.as_secs_f64())) {
        (None, _) => None,
        (Some(clockwise), Some(period)) if period <= 1.0 => Some(LaserTurn { period, clockwise }),
        (Some(_), _) => {
            let message = "turns, and has no `rate` of 1 to 100 Hz: add the turns in a second";
            table.fault(report, &table.key_span("turning"), message);
            return None;
        }
    };
    Some(LaserModel {
        name,
        config: LaserConfig {
            mount: mount?,
            height: height?,
            beams: beams?,
            field_of_view: view?,
            range_min: range.min,
            range_max: range.max,
            sigma: range.sigma,
            intensity: intensity?,
            turn,
            dropped_beams: dropped?,
            no_return: no_return?,
            stream: 0,
        },
        period,
        delivery: delivery?,
    })
}

fn beams(node: &Node<'_>) -> Checked<usize> {
    let number = between(1.0, MAX_BEAMS, "beams")(node)?;
    if number.fract() == 0.0 {
        Ok(number as usize)
    } else {
        Err(WrongValue::new(
            node,
            format!("is {number}: expected a whole number"),
        ))
    }
}
