//! The geometry of a camera, which its users need to see where something is.

use core::mem::offset_of;

use jde_schema::prelude::*;

use crate::messages::typed;

/// A rectangle of pixels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Value)]
#[repr(C)]
#[value(name = "sensor_msgs/msg/RegionOfInterest")]
pub(crate) struct RegionOfInterest {
    pub(crate) x_offset: u32,
    pub(crate) y_offset: u32,
    pub(crate) height: u32,
    pub(crate) width: u32,
    pub(crate) do_rectify: Flag,
    pub(crate) padding: Padding<3>,
}

/// The geometry of a camera.
#[derive(Clone, Copy, Debug, Default, PartialEq, Value)]
#[repr(C)]
#[value(name = "sensor_msgs/msg/CameraInfo")]
pub(crate) struct CameraInfo {
    pub(crate) header: Header,
    pub(crate) height: u32,
    pub(crate) width: u32,
    pub(crate) distortion_model: Text<28>,
    /// Distortion.
    pub(crate) d: Seq<f64, 8>,
    /// Intrinsic matrix, row by row.
    pub(crate) k: [f64; 9],
    /// Rectification.
    pub(crate) r: [f64; 9],
    /// Projection, three rows of four.
    pub(crate) p: [f64; 12],
    pub(crate) binning_x: u32,
    pub(crate) binning_y: u32,
    pub(crate) roi: RegionOfInterest,
    pub(crate) padding: Padding<4>,
}

impl CameraInfo {
    /// The geometry of a camera without distortion, from the bytes of a picture with a horizontal field of view in rad.
    pub(crate) fn of(image: &[u8], field_of_view: f64) -> Self {
        let size = |at: usize| u32::from_ne_bytes(image[at..].first_chunk().copied().unwrap_or_default());
        let [rows, columns] = [offset_of!(Image, height), offset_of!(Image, width)].map(size);
        let (width, height) = (f64::from(columns), f64::from(rows));
        let focal = width / 2.0 / (field_of_view / 2.0).tan();
        // The middle of the first pixel is at 0, 0.
        let [x, y] = [(width - 1.0) / 2.0, (height - 1.0) / 2.0];
        let mut d = Seq::new();
        d.resize(5);
        Self {
            header: typed(&image[..size_of::<Header>()]),
            height: rows,
            width: columns,
            distortion_model: Text::new("plumb_bob"),
            d,
            k: [focal, 0.0, x, 0.0, focal, y, 0.0, 0.0, 1.0],
            r: [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0],
            p: [focal, 0.0, x, 0.0, 0.0, focal, y, 0.0, 0.0, 0.0, 1.0, 0.0],
            ..Self::default()
        }
    }
}

/// Returns the topic of the geometry of a camera, beside that of its pictures, as in ROS 2: `/depth/camera_info` for
/// `/depth/image`.
pub(crate) fn topic(image: &str) -> String {
    let (camera, _) = image.rsplit_once('/').unwrap_or_default();
    format!("{camera}/camera_info")
}

#[cfg(test)]
mod tests {
    use jde_ros_node::Quality;

    use super::*;
    use crate::messages::Codec;

    #[test]
    fn a_place_in_space_is_seen_where_the_geometry_says() {
        let mut image = Image::boxed();
        (image.width, image.height) = (320, 240);
        let info = CameraInfo::of(image.as_bytes(), std::f64::consts::FRAC_PI_2);
        // The right edge of the picture is seen at 45 degrees, half a pixel beyond the middle of the last column.
        let column = |right: f64, into: f64| info.p[0] * right / into + info.p[2];
        assert!((column(1.0, 1.0) - 319.5).abs() < 1e-9);
        assert!((column(-1.0, 1.0) + 0.5).abs() < 1e-9);
        assert!((info.k[0] - 160.0).abs() < 1e-9 && info.k[0] == info.k[4]);
        assert_eq!([info.k[2], info.k[5]], [159.5, 119.5]);
        assert_eq!(info.d.as_slice(), [0.0; 5]);
    }

    #[test]
    fn it_has_the_type_and_the_topic_of_ros() {
        let topic = Codec::<CameraInfo>::new().topic(topic("/robot/depth/image"), Quality::SENSOR_DATA);
        assert_eq!(topic.name, "/robot/depth/camera_info");
        assert_eq!(topic.type_name, "sensor_msgs/msg/CameraInfo");
        // From ROS 2 Jazzy, as computed by `rosbags` 0.11.9.
        assert_eq!(
            topic.hash,
            "RIHS01_b3dfd68ff46c9d56c80fd3bd4ed22c7a4ddce8c8348f2f59c299e73118e7e275"
        );
        assert_eq!(super::topic("/image"), "/camera_info");
    }
}
