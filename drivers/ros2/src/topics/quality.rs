//! Qualities of service by their names in application files.

use jde_ros_node::Quality;
use jde_schema::describe::Type;

/// The names, and the qualities of service that they mean.
const NAMES: [(&str, Quality); 2] = [
    ("sensor_data", Quality::SENSOR_DATA),
    ("default", Quality::DEFAULT),
];

/// The types whose topics have the quality of sensors.
const SENSORS: [&str; 9] = [
    "sensor_msgs/msg/LaserScan",
    "sensor_msgs/msg/Image",
    "sensor_msgs/msg/Imu",
    "sensor_msgs/msg/Range",
    "sensor_msgs/msg/BatteryState",
    "nav_msgs/msg/Odometry",
    "jde_msgs/msg/RangeRing",
    "jde_msgs/msg/PositionFix",
    "jde_msgs/msg/Bumpers",
];

/// Returns the quality of service of that name, or the usual one of the type if the name is empty.
///
/// # Errors
/// If there is no quality of that name.
pub(super) fn quality(name: &str, value_type: &Type) -> Result<Quality, String> {
    if name.is_empty() {
        return Ok(match value_type.name.as_str() {
            name if SENSORS.contains(&name) => Quality::SENSOR_DATA,
            _ => Quality::DEFAULT,
        });
    }
    let known = NAMES.iter().find(|(known, _)| *known == name);
    known.map(|(_, quality)| *quality).ok_or_else(|| {
        let names = NAMES.map(|(name, _)| name).join(", ");
        format!("`qos` is \"{name}\"; expected one of {names}, or nothing for that of the type")
    })
}
