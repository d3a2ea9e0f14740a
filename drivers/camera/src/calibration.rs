//! The calibration of a camera, from its file to the export beside the pictures.

use std::path::Path;

use jde_schema::prelude::*;
use jde_schema::types::CameraInfo;
use jde_vision::read_calibration;

/// Returns the calibration of a file; `None` if no file is named.
pub(crate) fn read(file: &str) -> Result<Option<CameraInfo>> {
    Ok(match file {
        "" => None,
        file => Some(read_calibration(Path::new(file)).map_err(|faults| format!("{faults:#}"))?),
    })
}

/// Exports the calibration with the time and the frame of a picture.
pub(crate) fn publish(
    cx: &Context,
    export: &mut Export<CameraInfo>,
    info: Option<&CameraInfo>,
    header: &Header,
) {
    if let Some(info) = info {
        export.write(
            cx,
            CameraInfo {
                header: *header,
                ..*info
            },
        );
    }
}
