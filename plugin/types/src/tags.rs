//! Tags that a schema finds in pictures.

use crate::{Header, Padding, Pose, Seq, Text, Value};

/// A tag in a picture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Value)]
#[repr(C)]
#[value(name = "jde_msgs/msg/TagDetection")]
pub struct TagDetection {
    /// The family, as "tag36h11".
    pub family: Text<28>,
    /// The number of the tag in its family.
    pub id: u32,
    /// Bits that were read wrongly.
    pub hamming: u32,
    /// How clearly black and white cells differ, from 0 up to about 250. False tags have small margins.
    pub margin: f64,
    /// Column and row of the lower left corner of its black border, then of the lower right, the upper right and
    /// the upper left one, as one who reads the tag sees it, from the upper left corner of the picture.
    #[value(unit = "px")]
    pub corners: [f64; 8],
    /// Its pose in the frame of the camera. The origin of its own frame is its middle, x points to the right and
    /// y down as one who reads the tag sees it, z into the tag.
    pub pose: Pose,
    /// The mean distance between the corners and where the pose puts them.
    #[value(unit = "px")]
    pub error: f64,
    /// `error` as a share of that of the other pose under which the tag looks nearly the same, 0 to 1: close to 1,
    /// either of both may be the true one.
    pub ambiguity: f64,
}

/// The tags in a picture, by family and number.
#[derive(Clone, Copy, Debug, Default, PartialEq, Value)]
#[repr(C)]
#[value(name = "jde_msgs/msg/TagDetections")]
pub struct TagDetections {
    /// Time at which the picture was taken, and the frame of the camera.
    pub header: Header,
    /// Number of tags that did not fit below.
    pub left_out: u32,
    /// Unused bytes.
    pub padding: Padding<4>,
    /// The tags.
    pub tags: Seq<TagDetection, 32>,
}
