//! Qualities of service, by name and by field, as application files state them.

use jde_ros_node::Quality;
use jde_schema::describe::Type;
use jde_schema::types::Twist;

use super::publication::is_of;

/// What an entry states of its quality of service. What it does not state is empty or 0.
#[derive(Clone, Copy)]
pub(super) struct QualitySettings<'s> {
    pub(super) qos: &'s str,
    pub(super) reliability: &'s str,
    pub(super) durability: &'s str,
    pub(super) depth: u32,
    /// Whether the topic is published.
    pub(super) is_published: bool,
}

/// The names, and the qualities of service that they mean.
const NAMES: [(&str, Quality); 3] = [
    ("sensor_data", Quality::SENSOR_DATA),
    ("default", Quality::DEFAULT),
    ("latched", Quality::LATCHED),
];
const RELIABILITIES: [(&str, bool); 2] = [("best_effort", false), ("reliable", true)];
const DURABILITIES: [(&str, bool); 2] = [("volatile", false), ("transient_local", true)];
/// The most messages that a topic keeps.
const MAX_DEPTH: u32 = 10_000;

/// The types whose topics have the quality of sensors.
const SENSORS: [&str; 13] = [
    "sensor_msgs/msg/LaserScan",
    "sensor_msgs/msg/Image",
    "sensor_msgs/msg/CompressedImage",
    "sensor_msgs/msg/CameraInfo",
    "sensor_msgs/msg/PointCloud2",
    "sensor_msgs/msg/NavSatFix",
    "sensor_msgs/msg/Imu",
    "sensor_msgs/msg/Range",
    "sensor_msgs/msg/BatteryState",
    "nav_msgs/msg/Odometry",
    "jde_msgs/msg/RangeRing",
    "jde_msgs/msg/PositionFix",
    "jde_msgs/msg/Bumpers",
];

/// Returns the quality of service that an entry states, or the usual one of the type where it states none.
///
/// # Errors
/// If there is no quality of that name, or a velocity is latched: an old one would be driven.
pub(super) fn quality(settings: QualitySettings<'_>, value_type: &Type) -> Result<Quality, String> {
    let mut quality =
        named("qos", settings.qos, &NAMES)?.unwrap_or_else(|| usual(settings.is_published, value_type));
    if let Some(reliable) = named("reliability", settings.reliability, &RELIABILITIES)? {
        quality.reliable = reliable;
    }
    if let Some(latched) = named("durability", settings.durability, &DURABILITIES)? {
        quality.latched = latched;
    }
    if quality.latched && is_of::<Twist>(value_type) {
        return Err(
            "a velocity cannot be latched: a program that connects later would drive by an old one"
                .to_owned(),
        );
    }
    match settings.depth {
        0 => {}
        depth @ 1..=MAX_DEPTH => quality.depth = depth as usize,
        depth => return Err(format!("`depth` is {depth}; expected at most {MAX_DEPTH}")),
    }
    Ok(quality)
}

/// The quality of a type. An odometry is published reliably, as the controllers of ROS 2 do, since what localizes a robot
/// may require it; a subscription requires less.
fn usual(is_published: bool, value_type: &Type) -> Quality {
    match value_type.name.as_str() {
        "nav_msgs/msg/OccupancyGrid" => Quality::LATCHED,
        "nav_msgs/msg/Odometry" if is_published => Quality::DEFAULT,
        name if SENSORS.contains(&name) => Quality::SENSOR_DATA,
        _ => Quality::DEFAULT,
    }
}

fn named<T: Copy>(key: &str, name: &str, known: &[(&str, T)]) -> Result<Option<T>, String> {
    if name.is_empty() {
        return Ok(None);
    }
    match known.iter().find(|(known, _)| *known == name) {
        Some((_, value)) => Ok(Some(*value)),
        None => {
            let names: Vec<_> = known.iter().map(|(name, _)| *name).collect();
            Err(format!(
                "`{key}` is \"{name}\"; expected one of {}",
                names.join(", ")
            ))
        }
    }
}

#[cfg(test)]
mod tests {
    use jde_schema::prelude::{LaserScan, Odometry, Value};

    use super::*;

    #[test]
    fn fields_change_the_quality_of_a_name_or_of_the_type() {
        let none = QualitySettings {
            qos: "",
            reliability: "",
            durability: "",
            depth: 0,
            is_published: true,
        };
        let odometry = Odometry::describe();
        assert_eq!(quality(none, &odometry), Ok(Quality::DEFAULT));
        let subscribed = QualitySettings {
            is_published: false,
            ..none
        };
        assert_eq!(quality(subscribed, &odometry), Ok(Quality::SENSOR_DATA));
        let scan = LaserScan::describe();
        let of = |settings| quality(settings, &scan);
        assert_eq!(of(none), Ok(Quality::SENSOR_DATA));
        let latched = QualitySettings {
            qos: "latched",
            ..none
        };
        assert_eq!(of(latched), Ok(Quality::LATCHED));
        let fields = QualitySettings {
            reliability: "reliable",
            durability: "transient_local",
            depth: 7,
            ..none
        };
        let expected = Quality {
            reliable: true,
            latched: true,
            depth: 7,
        };
        assert_eq!(of(fields), Ok(expected));
        for (wrong, key) in [
            (QualitySettings { qos: "fast", ..none }, "`qos` is \"fast\""),
            (
                QualitySettings {
                    reliability: "yes",
                    ..none
                },
                "`reliability`",
            ),
            (
                QualitySettings {
                    durability: "yes",
                    ..none
                },
                "`durability`",
            ),
            (
                QualitySettings {
                    depth: 10_001,
                    ..none
                },
                "`depth`",
            ),
        ] {
            assert!(of(wrong).unwrap_err().contains(key));
        }
    }
}
