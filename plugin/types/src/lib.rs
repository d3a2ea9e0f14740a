//! The standard interfaces of sensors and actuators, and the trait that makes a structure a value that
//! schemas can share.
//!
//! Units are SI, and axes follow ROS REP-103 (x ahead, y left, z up, counter-clockwise positive). A standard
//! type has the name and the fields of its ROS 2 interface; jde's own types are in the package `jde_msgs`.
//! The crate refuses to compute behaviour.

extern crate self as jde_types;

mod blobs;
mod body;
mod camera;
mod chunk;
mod cloud;
mod geometry;
mod joints;
mod measured;
mod merge;
mod mission;
mod modulated;
mod nav;
mod padding;
mod part;
mod people;
mod picture;
mod range;
mod satellite;
mod scalar;
mod scenery;
mod sensor;
mod seq;
mod services;
mod stamp;
mod tags;
mod text;
mod transform;
mod value;
mod zones;

pub use blobs::{ColorBlob, ColorBlobs};
pub use body::{Body, Footprint, Mount};
pub use camera::{CameraInfo, RegionOfInterest};
pub use chunk::{Chunk, ChunkStep};
pub use cloud::{PointCloud2, PointField};
pub use geometry::{
    Point, Point2D, Pose, Pose2D, PoseStamped, PoseWithCovariance, Quaternion, Twist, TwistWithCovariance,
    Vector3, normalize_angle,
};
pub use jde_macros::{Choice, Value};
pub use joints::{JointState, Name};
pub use measured::{Check, Checks, Echo, Repeats, Unmeasured, check_beams};
pub use merge::Beams;
pub use mission::{Mission, Truth};
pub use modulated::{Modulated, wire};
pub use nav::{MapMetaData, OccupancyGrid, Odometry, Path, Route, Start, Target};
pub use padding::{Flag, Padding};
pub use part::{FieldLayout, Part};
pub use people::{Person, Persons};
pub use picture::{ForeignPicture, PictureFault};
pub use range::{Ahead, LaserPoint, LaserScan, Range, RangeRing, SonarEcho};
pub use satellite::{NavSatFix, NavSatStatus};
pub use scenery::{Movers, Scenery, Thing};
pub use sensor::{
    BatteryState, Bumpers, CompressedImage, Connection, Image, Imu, LineSensor, PanTilt, PositionFix,
    WheelEncoders,
};
pub use seq::Seq;
pub use services::{
    EmptyRequest, EmptyResponse, SetBoolRequest, SetBoolResponse, TriggerRequest, TriggerResponse,
};
pub use stamp::{Frame, Header, Time};
pub use tags::{TagDetection, TagDetections};
pub use text::{Text, TooLong};
pub use transform::{Transform, TransformStamped};
pub use value::Value;
pub use zones::{Lanes, Strip, Zone, Zones};

/// Returns the descriptions of all standard types, each after the types that it contains. Texts and arrays on
/// their own are left out, because each capacity is a type of its own.
#[must_use]
pub fn standard() -> Vec<jde_abi::describe::Type> {
    vec![
        Flag::describe(),
        u8::describe(),
        u16::describe(),
        u32::describe(),
        u64::describe(),
        i8::describe(),
        i16::describe(),
        i32::describe(),
        i64::describe(),
        f32::describe(),
        f64::describe(),
        Time::describe(),
        Header::describe(),
        Point::describe(),
        Vector3::describe(),
        Quaternion::describe(),
        Pose::describe(),
        PoseStamped::describe(),
        PoseWithCovariance::describe(),
        Point2D::describe(),
        Pose2D::describe(),
        Transform::describe(),
        TransformStamped::describe(),
        Twist::describe(),
        TwistWithCovariance::describe(),
        Chunk::describe(),
        ChunkStep::describe(),
        Odometry::describe(),
        MapMetaData::describe(),
        OccupancyGrid::describe(),
        Path::describe(),
        Route::describe(),
        Start::describe(),
        Target::describe(),
        Footprint::describe(),
        Mount::describe(),
        Body::describe(),
        Zone::describe(),
        Zones::describe(),
        Strip::describe(),
        Lanes::describe(),
        LaserScan::describe(),
        Range::describe(),
        RangeRing::describe(),
        Image::describe(),
        CompressedImage::describe(),
        RegionOfInterest::describe(),
        CameraInfo::describe(),
        PointField::describe(),
        PointCloud2::describe(),
        PanTilt::describe(),
        ColorBlob::describe(),
        ColorBlobs::describe(),
        TagDetection::describe(),
        TagDetections::describe(),
        Person::describe(),
        Persons::describe(),
        BatteryState::describe(),
        Bumpers::describe(),
        LineSensor::describe(),
        Imu::describe(),
        Name::describe(),
        JointState::describe(),
        NavSatStatus::describe(),
        NavSatFix::describe(),
        PositionFix::describe(),
        WheelEncoders::describe(),
        Connection::describe(),
        Mission::describe(),
        Truth::describe(),
        Thing::describe(),
        Scenery::describe(),
        Movers::describe(),
        EmptyRequest::describe(),
        EmptyResponse::describe(),
        SetBoolRequest::describe(),
        SetBoolResponse::describe(),
        TriggerRequest::describe(),
        TriggerResponse::describe(),
    ]
}

/// What the derive macros generate code with; not a public interface.
#[doc(hidden)]
pub mod derived {
    pub use crate::modulated::{Modulated, wire};
    pub use crate::part::{FieldLayout, Part, field};
    pub use crate::value::{Value, structure};
    pub use jde_abi::raw;
}
