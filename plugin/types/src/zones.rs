//! What an operator draws on a map, in forms for files.

use crate::{Point2D, Seq, Value};

/// An area of the floor: a polygon, in files `{ corners = [[1, 1], [2, 1], [2, 2]] }`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Value)]
#[repr(C)]
#[value(name = "jde_msgs/msg/Zone")]
pub struct Zone {
    /// At least three corners, in order, in the frame of the map. The last is connected to the first.
    pub corners: Seq<Point2D, 32>,
}

/// Areas of the floor, of which up to 16 fit: in files `{ zones = [{ corners = [[1, 1], ...] }, ...] }`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Value)]
#[repr(C)]
#[value(name = "jde_msgs/msg/Zones")]
pub struct Zones {
    /// The areas; they may overlap.
    pub zones: Seq<Zone, 16>,
}

/// A strip of the floor: a line with a width, in files `{ width = 0.6, points = [[1, 1], [4, 1]] }`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Value)]
#[repr(C)]
#[value(name = "jde_msgs/msg/Strip")]
pub struct Strip {
    /// The width.
    #[value(unit = "m")]
    pub width: f64,
    /// At least two points, in order, in the frame of the map.
    pub points: Seq<Point2D, 32>,
}

/// Lanes, the strips that paths prefer, of which up to 16 fit: in files
/// `{ lanes = [{ width = 0.6, points = [[1, 1], ...] }, ...] }`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Value)]
#[repr(C)]
#[value(name = "jde_msgs/msg/Lanes")]
pub struct Lanes {
    /// The strips; they may cross and overlap.
    pub lanes: Seq<Strip, 16>,
}

impl Zones {
    /// No area.
    pub const EMPTY: Self = Self { zones: Seq::new() };
}

impl Lanes {
    /// No lane.
    pub const EMPTY: Self = Self { lanes: Seq::new() };
}
