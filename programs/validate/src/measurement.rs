//! What imports read: zeros; of a sensor the least that is a measurement, as a host delivers no other.

use jde_abi::describe::Type;
use jde_loader::AlignedBytes;
use jde_types::{
    CompressedImage, Image, LaserScan, Odometry, PointCloud2, PointField, Quaternion, Range, RangeRing, Text,
    Value,
};

/// Returns a value of a type.
pub(crate) fn value_of(value_type: &Type) -> AlignedBytes {
    match value_type.name.as_str() {
        "sensor_msgs/msg/LaserScan" => filled(value_type, |scan: &mut LaserScan| {
            scan.range_max = 1.0;
            // With room for it, a number is added.
            let _ = scan.ranges.push(f32::INFINITY);
        }),
        "jde_msgs/msg/RangeRing" => filled(value_type, |ring: &mut RangeRing| {
            ring.max_range = 1.0;
            let _ = ring.ranges.push(f32::INFINITY);
        }),
        "sensor_msgs/msg/Range" => filled(value_type, |range: &mut Range| {
            (range.max_range, range.range) = (1.0, f32::INFINITY);
        }),
        "nav_msgs/msg/Odometry" => filled(value_type, |odometry: &mut Odometry| {
            odometry.pose.pose.orientation = Quaternion::IDENTITY;
        }),
        "sensor_msgs/msg/Image" => filled(value_type, |image: &mut Image| {
            (image.width, image.height, image.step) = (1, 1, 3);
            image.encoding = Text::new("rgb8");
            image.data.resize(3);
        }),
        "sensor_msgs/msg/CompressedImage" => filled(value_type, |image: &mut CompressedImage| {
            image.data.resize(1);
        }),
        "sensor_msgs/msg/PointCloud2" => filled(value_type, |cloud: &mut PointCloud2| {
            for (name, offset) in [("x", 0), ("y", 4), ("z", 8)] {
                let _ = cloud.fields.push(PointField {
                    name: Text::new(name),
                    offset,
                    datatype: PointField::FLOAT32,
                    count: 1,
                    ..PointField::default()
                });
            }
            (cloud.width, cloud.height, cloud.point_step, cloud.row_step) = (1, 1, 12, 12);
            cloud.data.resize(12);
        }),
        _ => AlignedBytes::zeros(value_type.bytes),
    }
}

fn filled<T: Value>(value_type: &Type, fill: impl Fn(&mut T)) -> AlignedBytes {
    let mut bytes = AlignedBytes::zeros(value_type.bytes);
    if value_type.difference(&T::describe()).is_none()
        && let Some(value) = T::view_mut(bytes.bytes_mut())
    {
        fill(value);
    }
    bytes
}

#[cfg(test)]
mod tests {
    use jde_types::Checks;

    use super::*;

    #[test]
    fn the_value_of_each_sensor_is_a_measurement() {
        for value_type in [
            LaserScan::describe(),
            RangeRing::describe(),
            Range::describe(),
            Odometry::describe(),
            Image::describe(),
            CompressedImage::describe(),
            PointCloud2::describe(),
        ] {
            let checks = Checks::of(&value_type).expect("it is of a sensor");
            let value = value_of(&value_type);
            assert_eq!((checks.measured)(value.bytes()), Ok(()), "{}", value_type.name);
        }
    }
}
