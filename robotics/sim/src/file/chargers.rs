//! The chargers of a world file.

use super::document::{Document, Table};
use super::fixtures::each;
use super::values;
use crate::charger::Charger;

/// The default radius, in metres: the play of the contacts of a dock.
const RADIUS: f64 = 0.1;
/// The default current, in amperes.
const CURRENT: f64 = 3.0;

pub(crate) fn read(document: &Document<'_>, root: &Table<'_>) -> Option<Vec<Charger>> {
    let known = ["name", "place", "radius", "current"];
    each(document, root, "chargers", "charger", &known, |table, _| {
        let place = table.required("place", values::point);
        let radius = table.optional("radius", RADIUS, values::positive);
        let current = table.optional("current", CURRENT, values::positive);
        Some(Charger {
            place: place?,
            radius: radius?,
            current: current?,
        })
    })
}
