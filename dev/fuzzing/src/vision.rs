//! What must hold for any bytes. The fuzzer runs it, too.

use std::path::Path;

use jde_vision::{CameraModel, parse_calibration};

/// A file is a calibration or refused, and a camera shows each ray that it has of a place at that place.
pub(crate) fn calibration(data: &[u8]) {
    let Ok(text) = core::str::from_utf8(data) else {
        return;
    };
    let info = match parse_calibration(Path::new("c.yaml"), text) {
        Ok(info) => info,
        Err(faults) => return assert!(!faults.to_string().is_empty()),
    };
    let size = [info.width, info.height].map(|pixels| pixels as usize);
    let camera =
        CameraModel::calibrated(&info, size, false).expect("a calibration is of pictures of its size");
    for place in [[0.5, 0.5], size.map(|pixels| pixels as f64 / 3.0)] {
        if let Some(seen) = camera.ray(place).and_then(|ray| camera.pixel(ray)) {
            let distance = (seen[0] - place[0]).hypot(seen[1] - place[1]);
            assert!(distance < 1e-3, "{place:?} is seen at {seen:?}");
        }
    }
}
