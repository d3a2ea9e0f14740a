//! Which geometry the pictures of a camera have, for the schemas that look: what the camera states, what a file states,
//! or a field of view alone.

use std::path::Path;

use jde_types::CameraInfo;

use crate::calibration::read_calibration;
use crate::camera::CameraModel;

/// The geometry of one camera. Its file is read once.
#[derive(Debug, Default)]
pub struct CameraGeometry {
    file: Option<CameraInfo>,
    rectified: bool,
}

impl CameraGeometry {
    /// Reads the calibration file; an empty path is none. `rectified`: the pictures are without distortion, as those of
    /// `image_rect`.
    ///
    /// # Errors
    /// It cannot be read, or is no calibration.
    pub fn new(file: &str, rectified: bool) -> Result<Self, String> {
        let file = match file {
            "" => None,
            file => Some(read_calibration(Path::new(file)).map_err(|faults| format!("{faults:#}"))?),
        };
        Ok(Self { file, rectified })
    }

    /// Returns the camera of pictures of some columns and rows: by what the camera states, else by the file, else a
    /// pinhole with this horizontal field of view in rad.
    ///
    /// # Errors
    /// The calibration is none for such pictures.
    pub fn camera(
        &self,
        size: [usize; 2],
        stated: Option<&CameraInfo>,
        field_of_view: f64,
    ) -> Result<CameraModel, String> {
        match stated.or(self.file.as_ref()) {
            Some(info) => CameraModel::calibrated(info, size, self.rectified),
            None => Ok(CameraModel::new(size, field_of_view)),
        }
    }
}
