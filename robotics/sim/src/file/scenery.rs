//! The lighting of a world, and its sky.
//!
//! For pictures only: no other sensor uses them.

use super::values;
use crate::camera::Light;
use jde_document::{FaultReport, Section};

pub(crate) fn light(report: &mut FaultReport<'_>, root: &Section<'_>) -> Option<Light> {
    let default = Light::default();
    let sky = root.optional(report, "sky", default.sky, values::color);
    let direction = direction(report, root, default.direction);
    Some(Light {
        direction: direction?,
        sky: sky?,
    })
}

/// Returns the unit vector toward the light.
fn direction(report: &mut FaultReport<'_>, root: &Section<'_>, default: [f64; 3]) -> Option<[f64; 3]> {
    if root.get("light").is_none() {
        return Some(default);
    }
    let table = root.nested(report, "light", &["from_deg", "height_deg"])?;
    let (from, height) = (
        table.required(report, "from_deg", values::number),
        table.required(report, "height_deg", values::number),
    );
    let (sin, cos) = libm::sincos(from?.to_radians());
    let (up, along) = libm::sincos(height?.to_radians());
    Some([along * cos, along * sin, up])
}
