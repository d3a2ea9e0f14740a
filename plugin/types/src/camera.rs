//! The geometry of a camera: where in its pictures something is seen.

use crate::{Flag, Header, Padding, Seq, Text, Value};

/// A rectangle of the pixels of a camera.
#[derive(Clone, Copy, Debug, Default, PartialEq, Value)]
#[repr(C)]
#[value(name = "sensor_msgs/msg/RegionOfInterest")]
pub struct RegionOfInterest {
    /// First column.
    #[value(unit = "px")]
    pub x_offset: u32,
    /// First row.
    #[value(unit = "px")]
    pub y_offset: u32,
    /// Rows; 0 for all.
    #[value(unit = "px")]
    pub height: u32,
    /// Columns; 0 for all.
    #[value(unit = "px")]
    pub width: u32,
    /// Whether the rectangle is of the rectified picture.
    pub do_rectify: Flag,
    /// Unused bytes.
    pub padding: Padding<3>,
}

/// The calibration of a camera, as ROS has it beside its pictures (REP-104). The middle of the first pixel is at
/// 0, 0.
#[derive(Clone, Copy, Debug, Default, PartialEq, Value)]
#[repr(C)]
#[value(name = "sensor_msgs/msg/CameraInfo")]
pub struct CameraInfo {
    /// Time of the picture, and the frame of the camera.
    pub header: Header,
    /// Rows of the pictures of the calibration.
    #[value(unit = "px")]
    pub height: u32,
    /// Columns of the pictures of the calibration.
    #[value(unit = "px")]
    pub width: u32,
    /// Model of the distortion: "plumb_bob", "rational_polynomial" or "equidistant".
    pub distortion_model: Text<28>,
    /// Coefficients of the distortion, in the order of OpenCV: k1, k2, p1, p2, k3, ...
    pub d: Seq<f64, 14>,
    /// Intrinsic matrix of the raw picture, row by row: fx, 0, cx, 0, fy, cy, 0, 0, 1. An fx of 0: uncalibrated.
    pub k: [f64; 9],
    /// Rectification, row by row: the rotation to the frame of the rectified picture.
    pub r: [f64; 9],
    /// Projection to the rectified picture, three rows of four: fx', 0, cx', Tx, 0, fy', cy', Ty, 0, 0, 1, 0.
    pub p: [f64; 12],
    /// Columns of the camera in a column of the picture; 0 and 1 are the same.
    pub binning_x: u32,
    /// Rows of the camera in a row of the picture; 0 and 1 are the same.
    pub binning_y: u32,
    /// The part of the camera's pixels that the picture shows, before binning.
    pub roi: RegionOfInterest,
    /// Unused bytes.
    pub padding: Padding<4>,
}

impl CameraInfo {
    /// Returns the calibration of pictures of some columns and rows without distortion, with a horizontal field of view
    /// in rad.
    #[must_use]
    pub fn pinhole([width, height]: [u32; 2], field_of_view: f64) -> Self {
        let focal = f64::from(width) / 2.0 / libm::tan(field_of_view / 2.0);
        let [x, y] = [width, height].map(|pixels| (f64::from(pixels) - 1.0) / 2.0);
        let mut d = Seq::new();
        d.resize(5);
        Self {
            height,
            width,
            distortion_model: Text::truncated("plumb_bob"),
            d,
            k: [focal, 0.0, x, 0.0, focal, y, 0.0, 0.0, 1.0],
            r: [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0],
            p: [focal, 0.0, x, 0.0, 0.0, focal, y, 0.0, 0.0, 0.0, 1.0, 0.0],
            ..Self::default()
        }
    }
}
