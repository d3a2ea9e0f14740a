//! The definitions of the common messages of ROS 2, for recordings that contain none: databases of Humble and before.

use std::collections::HashMap;
use std::sync::LazyLock;

use jde_ros::definition;

/// A message in each line: its name without the middle, and its fields. They are facts of ROS 2 Humble.
const MESSAGES: &str = "\
builtin_interfaces/Time: int32 sec; uint32 nanosec
builtin_interfaces/Duration: int32 sec; uint32 nanosec
std_msgs/Header: builtin_interfaces/Time stamp; string frame_id
std_msgs/Bool: bool data
std_msgs/Byte: byte data
std_msgs/Char: char data
std_msgs/Int8: int8 data
std_msgs/Int16: int16 data
std_msgs/Int32: int32 data
std_msgs/Int64: int64 data
std_msgs/UInt8: uint8 data
std_msgs/UInt16: uint16 data
std_msgs/UInt32: uint32 data
std_msgs/UInt64: uint64 data
std_msgs/Float32: float32 data
std_msgs/Float64: float64 data
std_msgs/String: string data
std_msgs/ColorRGBA: float32 r; float32 g; float32 b; float32 a
std_msgs/MultiArrayDimension: string label; uint32 size; uint32 stride
std_msgs/MultiArrayLayout: MultiArrayDimension[] dim; uint32 data_offset
std_msgs/ByteMultiArray: MultiArrayLayout layout; byte[] data
std_msgs/Int8MultiArray: MultiArrayLayout layout; int8[] data
std_msgs/Int16MultiArray: MultiArrayLayout layout; int16[] data
std_msgs/Int32MultiArray: MultiArrayLayout layout; int32[] data
std_msgs/Int64MultiArray: MultiArrayLayout layout; int64[] data
std_msgs/UInt8MultiArray: MultiArrayLayout layout; uint8[] data
std_msgs/UInt16MultiArray: MultiArrayLayout layout; uint16[] data
std_msgs/UInt32MultiArray: MultiArrayLayout layout; uint32[] data
std_msgs/UInt64MultiArray: MultiArrayLayout layout; uint64[] data
std_msgs/Float32MultiArray: MultiArrayLayout layout; float32[] data
std_msgs/Float64MultiArray: MultiArrayLayout layout; float64[] data
geometry_msgs/Vector3: float64 x; float64 y; float64 z
geometry_msgs/Vector3Stamped: std_msgs/Header header; Vector3 vector
geometry_msgs/Point: float64 x; float64 y; float64 z
geometry_msgs/Point32: float32 x; float32 y; float32 z
geometry_msgs/PointStamped: std_msgs/Header header; Point point
geometry_msgs/Quaternion: float64 x; float64 y; float64 z; float64 w
geometry_msgs/QuaternionStamped: std_msgs/Header header; Quaternion quaternion
geometry_msgs/Pose: Point position; Quaternion orientation
geometry_msgs/Pose2D: float64 x; float64 y; float64 theta
geometry_msgs/PoseArray: std_msgs/Header header; Pose[] poses
geometry_msgs/PoseStamped: std_msgs/Header header; Pose pose
geometry_msgs/PoseWithCovariance: Pose pose; float64[36] covariance
geometry_msgs/PoseWithCovarianceStamped: std_msgs/Header header; PoseWithCovariance pose
geometry_msgs/Polygon: Point32[] points
geometry_msgs/PolygonStamped: std_msgs/Header header; Polygon polygon
geometry_msgs/Transform: Vector3 translation; Quaternion rotation
geometry_msgs/TransformStamped: std_msgs/Header header; string child_frame_id; Transform transform
geometry_msgs/Twist: Vector3 linear; Vector3 angular
geometry_msgs/TwistStamped: std_msgs/Header header; Twist twist
geometry_msgs/TwistWithCovariance: Twist twist; float64[36] covariance
geometry_msgs/TwistWithCovarianceStamped: std_msgs/Header header; TwistWithCovariance twist
geometry_msgs/Accel: Vector3 linear; Vector3 angular
geometry_msgs/AccelStamped: std_msgs/Header header; Accel accel
geometry_msgs/AccelWithCovariance: Accel accel; float64[36] covariance
geometry_msgs/AccelWithCovarianceStamped: std_msgs/Header header; AccelWithCovariance accel
geometry_msgs/Wrench: Vector3 force; Vector3 torque
geometry_msgs/WrenchStamped: std_msgs/Header header; Wrench wrench
nav_msgs/Odometry: std_msgs/Header header; string child_frame_id; geometry_msgs/PoseWithCovariance pose; geometry_msgs/TwistWithCovariance twist
nav_msgs/Path: std_msgs/Header header; geometry_msgs/PoseStamped[] poses
sensor_msgs/CameraInfo: std_msgs/Header header; uint32 height; uint32 width; string distortion_model; float64[] d; float64[9] k; float64[9] r; float64[12] p; uint32 binning_x; uint32 binning_y; RegionOfInterest roi
sensor_msgs/RegionOfInterest: uint32 x_offset; uint32 y_offset; uint32 height; uint32 width; bool do_rectify
sensor_msgs/FluidPressure: std_msgs/Header header; float64 fluid_pressure; float64 variance
sensor_msgs/Illuminance: std_msgs/Header header; float64 illuminance; float64 variance
sensor_msgs/Joy: std_msgs/Header header; float32[] axes; int32[] buttons
sensor_msgs/MagneticField: std_msgs/Header header; geometry_msgs/Vector3 magnetic_field; float64[9] magnetic_field_covariance
sensor_msgs/RelativeHumidity: std_msgs/Header header; float64 relative_humidity; float64 variance
sensor_msgs/Temperature: std_msgs/Header header; float64 temperature; float64 variance
sensor_msgs/TimeReference: std_msgs/Header header; builtin_interfaces/Time time_ref; string source
tf2_msgs/TFMessage: geometry_msgs/TransformStamped[] transforms
rosgraph_msgs/Clock: builtin_interfaces/Time clock
diagnostic_msgs/KeyValue: string key; string value
rcl_interfaces/Log: builtin_interfaces/Time stamp; uint8 level; string name; string msg; string file; string function; uint32 line
";

/// Returns the definition of a message, with those of all that it contains. `None` if it is none of these.
pub(crate) fn definition_of(name: &str) -> Option<String> {
    static DEFINITIONS: LazyLock<HashMap<String, String>> = LazyLock::new(|| {
        let lines = MESSAGES.lines().filter_map(|line| line.split_once(": "));
        let named = lines.filter_map(|(name, fields)| {
            let (package, name) = name.split_once('/')?;
            Some((format!("{package}/msg/{name}"), fields.replace("; ", "\n")))
        });
        named.collect()
    });
    DEFINITIONS.get(name)?;
    definition::gather(name, |inner| Ok(DEFINITIONS.get(inner).cloned()), |_| false).ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_definition_is_complete() {
        for line in MESSAGES.lines() {
            let (package, rest) = line.split_once('/').unwrap();
            let name = format!("{package}/msg/{}", rest.split_once(": ").unwrap().0);
            let text = definition_of(&name)
                .unwrap_or_else(|| panic!("{name} contains something that is none of these"));
            let read = definition::read_interface(&name, &text, |_| 4, |_| None);
            assert!(read.is_ok(), "{name}: {read:?}");
        }
        assert_eq!(definition_of("acme_msgs/msg/Notes"), None);
    }
}
