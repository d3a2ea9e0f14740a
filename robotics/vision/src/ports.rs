//! The ports by which a schema knows its camera.

use jde_schema::prelude::*;
use jde_schema::types::CameraInfo;

use crate::camera::CameraModel;
use crate::geometry::CameraGeometry;

/// What a schema knows of the camera whose pictures it reads.
#[derive(PortBundle)]
pub struct CameraPorts {
    /// The calibration of the camera, as the camera states it beside its pictures. It counts before `calibration`.
    #[import(optional)]
    camera_info: Import<CameraInfo>,
    /// The calibration file of the camera, as ROS's `camera_calibration` writes it. It counts before `field_of_view`.
    #[modulation(default = "", unit = "file", fixed)]
    calibration: Modulation<Text<1024>>,
    /// Whether the pictures are rectified, without distortion; otherwise they are as the camera takes them.
    #[modulation(default = Flag::FALSE, fixed)]
    rectified: Modulation<Flag>,
    /// Horizontal field of view of a camera without calibration.
    #[modulation(default = 0.829, unit = "rad", min = 0.01, max = 3.1)]
    field_of_view: Modulation<f64>,
}

impl CameraPorts {
    /// Reads the calibration file.
    ///
    /// # Errors
    /// It cannot be read, or is no calibration.
    pub fn geometry(&self, cx: &Context) -> Result<CameraGeometry> {
        let file = self.calibration.get(cx);
        Ok(CameraGeometry::new(file.as_str(), self.rectified.get(cx).get())?)
    }

    /// Reports a calibration file that cannot be read.
    pub fn inspect(&self, cx: &Context, problems: &mut Problems) {
        problems.expect(&self.calibration, self.geometry(cx));
    }

    /// Returns whether `camera_info` is bound and has no value.
    #[must_use]
    pub fn is_unknown(&self, cx: &Context) -> bool {
        self.camera_info.is_bound(cx) && self.camera_info.get(cx).is_none()
    }

    /// Returns the camera of pictures of some columns and rows.
    ///
    /// # Errors
    /// The calibration is none for such pictures.
    pub fn model(
        &self,
        cx: &Context,
        geometry: &CameraGeometry,
        size: [usize; 2],
    ) -> Result<CameraModel, String> {
        let stated = self.camera_info.get(cx);
        geometry.camera(size, stated.as_deref(), self.field_of_view.get(cx))
    }
}
