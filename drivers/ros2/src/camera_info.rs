//! The geometry of a camera, which its users need to see where something is.

use core::mem::offset_of;

use jde_schema::prelude::*;
use jde_schema::types::CameraInfo;

use crate::messages::typed;

/// Returns the geometry of a camera without distortion, from the bytes of a picture with a horizontal field of view in
/// rad.
pub(crate) fn of(image: &[u8], field_of_view: f64) -> CameraInfo {
    let size = |at: usize| u32::from_ne_bytes(image[at..].first_chunk().copied().unwrap_or_default());
    CameraInfo {
        header: typed(&image[..size_of::<Header>()]),
        ..CameraInfo::pinhole(
            [offset_of!(Image, width), offset_of!(Image, height)].map(size),
            field_of_view,
        )
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
        let info = of(image.as_bytes(), std::f64::consts::FRAC_PI_2);
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
