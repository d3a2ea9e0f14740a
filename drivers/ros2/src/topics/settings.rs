//! The settings of a topic in the application file.

use jde_schema::prelude::*;

use super::quality::QualitySettings;

/// How a variable is published.
#[derive(Clone, Copy, Debug, Value)]
#[repr(C)]
#[value(name = "jde_msgs/msg/RosPublication")]
pub(crate) struct Publication {
    /// Least time between two messages; 0 for every new value.
    #[value(unit = "s")]
    pub(crate) period: f64,
    /// Pose on the base of the laser or the camera.
    pub(crate) mount: Pose2D,
    /// How high a camera is above the base.
    #[value(unit = "m")]
    pub(crate) height: f64,
    /// How far a camera looks down.
    #[value(unit = "rad")]
    pub(crate) tilt: f64,
    /// Horizontal field of view of a camera, whose geometry is then published beside the pictures; 0 if it is unknown.
    #[value(unit = "rad")]
    pub(crate) field_of_view: f64,
    /// How a picture is compressed: "jpeg" or "png"; empty for not at all.
    pub(crate) compressed: Text<12>,
    /// Quality of service: "sensor_data", "default" or "latched"; empty for that of the type.
    pub(crate) qos: Text<28>,
    /// "reliable" or "best_effort" instead of that of the quality.
    pub(crate) reliability: Text<12>,
    /// "volatile" or "transient_local" instead of that of the quality.
    pub(crate) durability: Text<24>,
    /// The messages that are kept, instead of that of the quality.
    pub(crate) depth: u32,
    /// Frame of the messages instead of that of the values; empty for theirs.
    pub(crate) frame: Text<64>,
    /// Frame that is at a pose, which is then also the transform to it; empty for none.
    pub(crate) child: Frame,
    /// Whether an odometry is also the transform from its frame to the base.
    pub(crate) transform: Flag,
    pub(crate) padding: Padding<3>,
}

/// How a topic is exported.
#[derive(Clone, Copy, Debug, Value)]
#[repr(C)]
#[value(name = "jde_msgs/msg/RosSubscription")]
pub(crate) struct Subscription {
    /// Age at which a value without a successor is retracted; 0 for never, negative for that of the type.
    #[value(unit = "s")]
    pub(crate) stale: f64,
    /// Rotation to the left of the scanner whose scans these are.
    #[value(unit = "rad")]
    pub(crate) yaw: f64,
    /// Quality of service: "sensor_data", "default" or "latched"; empty for that of the type.
    pub(crate) qos: Text<28>,
    /// "reliable" or "best_effort" instead of that of the quality.
    pub(crate) reliability: Text<12>,
    /// "volatile" or "transient_local" instead of that of the quality.
    pub(crate) durability: Text<24>,
    /// The messages that are kept, instead of that of the quality.
    pub(crate) depth: u32,
    /// Whether the messages are compressed pictures.
    pub(crate) compressed: Flag,
    /// Whether +∞, or the greatest range, of a scan says that nothing is within reach.
    pub(crate) inf_is_valid: Flag,
    pub(crate) padding: Padding<6>,
}

impl Publication {
    /// Every value, at the quality of its type.
    pub(crate) const DEFAULT: Self = Self {
        period: 0.0,
        mount: Pose2D::ORIGIN,
        height: 0.0,
        tilt: 0.0,
        field_of_view: 0.0,
        compressed: Text::new(""),
        qos: Text::new(""),
        reliability: Text::new(""),
        durability: Text::new(""),
        depth: 0,
        frame: Text::new(""),
        child: Frame::EMPTY,
        transform: Flag::TRUE,
        padding: Padding::ZERO,
    };

    pub(super) fn quality(&self) -> QualitySettings<'_> {
        QualitySettings {
            qos: self.qos.as_str(),
            reliability: self.reliability.as_str(),
            durability: self.durability.as_str(),
            depth: self.depth,
            is_published: true,
        }
    }
}

impl Subscription {
    /// At the quality of its type.
    pub(crate) const DEFAULT: Self = Self {
        stale: -1.0,
        yaw: 0.0,
        qos: Text::new(""),
        reliability: Text::new(""),
        durability: Text::new(""),
        depth: 0,
        compressed: Flag::FALSE,
        inf_is_valid: Flag::FALSE,
        padding: Padding::ZERO,
    };

    pub(super) fn quality(&self) -> QualitySettings<'_> {
        QualitySettings {
            qos: self.qos.as_str(),
            reliability: self.reliability.as_str(),
            durability: self.durability.as_str(),
            depth: self.depth,
            is_published: false,
        }
    }
}
