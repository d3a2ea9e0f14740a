//! The lighting of a world, and its sky.
//!
//! For pictures only: no other sensor uses them.

use super::document::{Document, Table};
use super::values;
use crate::camera::Light;

pub(crate) fn light(document: &Document<'_>, root: &Table<'_>) -> Option<Light> {
    let default = Light::default();
    let sky = root.optional("sky", default.sky, values::color);
    let direction = direction(document, root, default.direction);
    Some(Light {
        direction: direction?,
        sky: sky?,
    })
}

/// Returns the unit vector toward the light.
fn direction(document: &Document<'_>, root: &Table<'_>, default: [f64; 3]) -> Option<[f64; 3]> {
    let Some(item) = root.get("light") else {
        return Some(default);
    };
    let Some(keys) = item.get_ref().as_table() else {
        root.fault(
            &item.span(),
            "`light` is not a table: expected { from_deg = 60, height_deg = 50 }",
        );
        return None;
    };
    let known = ["from_deg", "height_deg"];
    let table = Table::new(document, keys, item.span(), "light".to_owned(), &known);
    let (from, height) = (
        table.required("from_deg", values::number),
        table.required("height_deg", values::number),
    );
    let (sin, cos) = libm::sincos(from?.to_radians());
    let (up, along) = libm::sincos(height?.to_radians());
    Some([along * cos, along * sin, up])
}
