//! What a schema sees in pictures by colour.

use crate::{Flag, Header, Padding, Seq, Value};

/// Connected pixels of one colour.
#[derive(Clone, Copy, Debug, Default, PartialEq, Value)]
#[repr(C)]
#[value(name = "jde_msgs/msg/ColorBlob")]
pub struct ColorBlob {
    /// The number of its colour, from 0 in the order of the schema's ranges.
    pub color: u32,
    /// Number of pixels.
    #[value(unit = "px")]
    pub count: u32,
    /// First column of the rectangle around it.
    #[value(unit = "px")]
    pub left: u16,
    /// First row of the rectangle around it.
    #[value(unit = "px")]
    pub top: u16,
    /// Columns of the rectangle around it.
    #[value(unit = "px")]
    pub width: u16,
    /// Rows of the rectangle around it.
    #[value(unit = "px")]
    pub height: u16,
    /// Column of its middle, from the left edge of the picture.
    #[value(unit = "px")]
    pub column: f32,
    /// Row of its middle, from the upper edge of the picture.
    #[value(unit = "px")]
    pub row: f32,
    /// Angle to its middle, positive to the left.
    #[value(unit = "rad")]
    pub bearing: f64,
    /// Angle to its middle above the horizon.
    #[value(unit = "rad")]
    pub elevation: f64,
    /// Where its lowest row meets the floor, ahead of the base; 0 if that is unknown.
    #[value(unit = "m")]
    pub x: f64,
    /// Where its lowest row meets the floor, to the left of the base; 0 if that is unknown.
    #[value(unit = "m")]
    pub y: f64,
    /// Whether x and y are known: the camera's height is, and its lowest row is below the horizon and in the
    /// picture.
    pub on_floor: Flag,
    /// Unused bytes.
    pub padding: Padding<7>,
}

/// The connected areas of some colours in a picture, the largest first.
#[derive(Clone, Copy, Debug, Default, PartialEq, Value)]
#[repr(C)]
#[value(name = "jde_msgs/msg/ColorBlobs")]
pub struct ColorBlobs {
    /// Time at which the picture was taken, and the frame of the angles.
    pub header: Header,
    /// Number of areas that did not fit below.
    pub left_out: u32,
    /// Unused bytes.
    pub padding: Padding<4>,
    /// The areas.
    pub blobs: Seq<ColorBlob, 32>,
}
