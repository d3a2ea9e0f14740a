//! The chargers of a world file.

use super::fixtures::each;
use super::values;
use crate::charger::Charger;
use jde_document::{FaultReport, Section};

/// The default radius, in metres: the play of the contacts of a dock.
const RADIUS: f64 = 0.1;
/// The default current, in amperes.
const CURRENT: f64 = 3.0;

pub(crate) fn read(report: &mut FaultReport<'_>, root: &Section<'_>) -> Option<Vec<Charger>> {
    let known = ["name", "place", "radius", "current"];
    each(report, root, "chargers", "charger", &known, |report, table, _| {
        let place = table.required(report, "place", values::point);
        let radius = table.optional(report, "radius", RADIUS, values::positive);
        let current = table.optional(report, "current", CURRENT, values::positive);
        Some(Charger {
            place: place?,
            radius: radius?,
            current: current?,
        })
    })
}
