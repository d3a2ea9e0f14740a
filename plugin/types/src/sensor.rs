//! The other sensors: camera, pan-tilt head, battery, bumpers, line sensor, inertial unit, position, wheel
//! encoders; and the connection of a driver to its device.

use crate::{Flag, Header, Padding, Point2D, Quaternion, Seq, Text, Value, Vector3};

/// An image of up to 640 × 480 pixels of three bytes, or 640 × 360 depths.
#[derive(Clone, Copy, PartialEq, Value)]
#[repr(C)]
#[value(name = "sensor_msgs/msg/Image")]
pub struct Image {
    /// Time, and the frame of the camera: x to the right of the image, y down, z into it.
    pub header: Header,
    /// Rows.
    pub height: u32,
    /// Columns.
    pub width: u32,
    /// Format of a pixel: "rgb8", "bgr8", "mono8"; "32FC1" for a depth in metres (REP-118).
    pub encoding: Text<28>,
    /// Whether numbers of several bytes begin with the most significant byte.
    pub is_bigendian: u8,
    /// Unused bytes.
    pub padding: Padding<3>,
    /// Size of a row in bytes.
    pub step: u32,
    /// Rows, from top to bottom.
    pub data: Seq<u8, { 640 * 480 * 3 }>,
}

/// A compressed image of up to 1 MiB. A stack has no room for this type: fill a loan, or memory of the heap.
#[derive(Clone, Copy, PartialEq, Value)]
#[repr(C)]
#[value(name = "sensor_msgs/msg/CompressedImage")]
pub struct CompressedImage {
    /// Time, and the frame of the camera, as of an `Image`.
    pub header: Header,
    /// Format: "jpeg" or "png", perhaps within more words, as in "rgb8; jpeg compressed bgr8".
    pub format: Text<60>,
    /// A file of that format.
    pub data: Seq<u8, { 1 << 20 }>,
}

/// Direction of a pan-tilt head. ROS has a joint state with joint names instead; two named angles need none.
#[derive(Clone, Copy, Debug, Default, PartialEq, Value)]
#[repr(C)]
#[value(name = "jde_msgs/msg/PanTilt")]
pub struct PanTilt {
    /// Time, and the frame of the head's base.
    pub header: Header,
    /// Angle to the left.
    #[value(unit = "rad")]
    pub pan: f64,
    /// Angle downwards: a rotation about the axis to the left (REP-103).
    #[value(unit = "rad")]
    pub tilt: f64,
    /// Angular velocity to the left.
    #[value(unit = "rad/s")]
    pub pan_velocity: f64,
    /// Angular velocity downwards.
    #[value(unit = "rad/s")]
    pub tilt_velocity: f64,
}

/// State of the battery. NaN marks what is not measured.
#[derive(Clone, Copy, Debug, PartialEq, Value)]
#[repr(C)]
#[value(name = "sensor_msgs/msg/BatteryState")]
pub struct BatteryState {
    /// Time.
    pub header: Header,
    /// Voltage.
    #[value(unit = "V")]
    pub voltage: f32,
    /// Temperature.
    #[value(unit = "degC")]
    pub temperature: f32,
    /// Current; negative while discharging.
    #[value(unit = "A")]
    pub current: f32,
    /// Present charge.
    #[value(unit = "Ah")]
    pub charge: f32,
    /// Charge when it was last full.
    #[value(unit = "Ah")]
    pub capacity: f32,
    /// Nominal charge.
    #[value(unit = "Ah")]
    pub design_capacity: f32,
    /// Charge, from 0 to 1.
    pub percentage: f32,
    /// 0 unknown, 1 charging, 2 discharging, 3 not charging, 4 full.
    pub power_supply_status: u8,
    /// 0 unknown, 1 good, 2 too hot, 3 dead, 4 overvoltage, 5 failure, 6 too cold, 7 and 8 a timer expired.
    pub power_supply_health: u8,
    /// 0 unknown, 1 NiMH, 2 Li-ion, 3 Li-polymer, 4 LiFe, 5 NiCd, 6 LiMn.
    pub power_supply_technology: u8,
    /// Whether a battery is present.
    pub present: Flag,
    /// Voltage of each cell.
    #[value(unit = "V")]
    pub cell_voltage: Seq<f32, 16>,
    /// Temperature of each cell.
    #[value(unit = "degC")]
    pub cell_temperature: Seq<f32, 16>,
    /// Location of the battery.
    pub location: Text<28>,
    /// Its serial number.
    pub serial_number: Text<28>,
}

/// Which bumpers are pressed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Value)]
#[repr(C)]
#[value(name = "jde_msgs/msg/Bumpers")]
pub struct Bumpers {
    /// Time, and the frame of the base.
    pub header: Header,
    /// Front bumpers, from left to right.
    pub front: Seq<Flag, 8>,
    /// Rear bumpers, from left to right in the direction of travel.
    pub rear: Seq<Flag, 8>,
    /// Whether the wheels are blocked while driven.
    pub stalled: Flag,
    /// Unused bytes.
    pub padding: Padding<3>,
}

/// The floor as a row of up to 32 reflectance cells sees it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Value)]
#[repr(C)]
#[value(name = "jde_msgs/msg/LineSensor")]
pub struct LineSensor {
    /// Time, and the frame of the base.
    pub header: Header,
    /// Position of each cell, in the frame of the base.
    pub cells: Seq<Point2D, 32>,
    /// Brightness of the floor below each cell, from 0 (black) to 1 (white).
    pub brightness: Seq<f32, 32>,
}

/// Measurement of an inertial unit. Covariances are row by row; one of zeros is unknown.
#[derive(Clone, Copy, Debug, Default, PartialEq, Value)]
#[repr(C)]
#[value(name = "sensor_msgs/msg/Imu")]
pub struct Imu {
    /// Time, and the frame of the unit.
    pub header: Header,
    /// Orientation in a fixed frame with z up (REP-145).
    pub orientation: Quaternion,
    /// Covariance of the rotations about x, y and z, rad²; the first is −1 if there is no orientation.
    pub orientation_covariance: [f64; 9],
    /// Turn rates about the unit's axes, rad/s.
    pub angular_velocity: Vector3,
    /// Their covariance, (rad/s)².
    pub angular_velocity_covariance: [f64; 9],
    /// Specific forces along the unit's axes, m/s²: at rest, the axis that is up shows 9.81 (REP-145).
    pub linear_acceleration: Vector3,
    /// Their covariance, (m/s²)².
    pub linear_acceleration_covariance: [f64; 9],
}

/// Measured position on the ground, as of a satellite receiver. ROS has latitude and longitude instead
/// (`sensor_msgs/msg/NavSatFix`); a robot that needs none of them is given metres. Without a fix there is no
/// value.
#[derive(Clone, Copy, Debug, Default, PartialEq, Value)]
#[repr(C)]
#[value(name = "jde_msgs/msg/PositionFix")]
pub struct PositionFix {
    /// Time, and the fixed frame of the position.
    pub header: Header,
    /// Position of the antenna along x.
    #[value(unit = "m")]
    pub x: f64,
    /// Position of the antenna along y.
    #[value(unit = "m")]
    pub y: f64,
    /// Covariance of x and y, row by row.
    #[value(unit = "m2")]
    pub covariance: [f64; 4],
}

/// Counts of the two wheels' encoders since the driver's first reading.
#[derive(Clone, Copy, Debug, Default, PartialEq, Value)]
#[repr(C)]
#[value(name = "jde_msgs/msg/WheelEncoders")]
pub struct WheelEncoders {
    /// Time, and the frame of the base.
    pub header: Header,
    /// Ticks of the left wheel. Backward motion counts down; counts never wrap.
    pub left: i64,
    /// Ticks of the right wheel.
    pub right: i64,
    /// Ticks for one metre of rolling; 0 if unknown.
    #[value(unit = "1/m")]
    pub ticks_per_meter: f64,
}

/// Connection of a driver to its device.
#[derive(Clone, Copy, Debug, Default, PartialEq, Value)]
#[repr(C)]
#[value(name = "jde_msgs/msg/Connection")]
pub struct Connection {
    /// Time of the last change of state, or of the last failed attempt.
    pub header: Header,
    /// 0 not tried yet, 1 connecting, 2 connected, 3 lost.
    pub state: u8,
    /// Unused bytes.
    pub padding: Padding<3>,
    /// Attempts since the last connection.
    pub attempts: u32,
    /// Name that the device reports, or why it is not connected.
    pub note: Text<120>,
}

impl Connection {
    /// State: no attempt yet.
    pub const IDLE: u8 = 0;
    /// State: an attempt is under way.
    pub const CONNECTING: u8 = 1;
    /// State: the device is connected.
    pub const CONNECTED: u8 = 2;
    /// State: the connection was lost, or an attempt failed. The next attempt starts automatically.
    pub const LOST: u8 = 3;

    /// Returns whether the device is connected.
    pub fn is_up(&self) -> bool {
        self.state == Self::CONNECTED
    }
}

impl Default for Image {
    fn default() -> Self {
        Self::zeroed()
    }
}

impl core::fmt::Debug for Image {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        write!(
            f,
            "Image({} x {} {}, {} bytes)",
            self.width,
            self.height,
            self.encoding,
            self.data.len()
        )
    }
}

impl core::fmt::Debug for CompressedImage {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        write!(f, "CompressedImage({}, {} bytes)", self.format, self.data.len())
    }
}

/// All measurements unknown.
impl Default for BatteryState {
    fn default() -> Self {
        Self {
            voltage: f32::NAN,
            temperature: f32::NAN,
            current: f32::NAN,
            charge: f32::NAN,
            capacity: f32::NAN,
            design_capacity: f32::NAN,
            percentage: f32::NAN,
            ..Self::zeroed()
        }
    }
}

impl Bumpers {
    /// Returns whether any bumper is pressed.
    #[must_use]
    pub fn any(&self) -> bool {
        self.front.iter().chain(&self.rear).any(|pressed| pressed.get())
    }
}
