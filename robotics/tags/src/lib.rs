//! Finds AprilTags in pictures, and where they are before the camera (Wang and Olson, "AprilTag 2: efficient and
//! robust fiducial detection", IROS 2016).
//!
//! Pure functions of their arguments: no clock, no input or output, no thread. The same picture gives the same
//! tags to the bit. Places in a picture are columns and rows in px from its upper left corner, so that the middle
//! of the first pixel is at (0.5, 0.5).
//!
//! ```
//! use jde_tags::{Detector, Family, Gray};
//!
//! // Tag 7 with 8 px a cell, and a margin.
//! let side = 8 * 12;
//! let cells = Family::Tag36h11.cells(7).expect("the family has a tag 7");
//! let mut pixels = vec![255; side * side];
//! for (number, pixel) in pixels.iter_mut().enumerate() {
//!     let (column, row) = (number % side / 8, number / side / 8);
//!     if (1..11).contains(&column) && (1..11).contains(&row) && !cells[(row - 1) * 10 + column - 1] {
//!         *pixel = 0;
//!     }
//! }
//! let tags = Detector::default().detect(&Gray::new([side, side], &pixels).expect("the sizes agree"));
//! assert_eq!((tags[0].id, tags[0].hamming), (7, 0));
//! ```

mod codes;
mod decode;
mod detector;
mod edges;
mod family;
mod gray;
mod homography;
mod line;
mod pose;
mod quad;
mod segments;
mod threshold;

pub use detector::{Detection, Detector};
pub use family::Family;
pub use gray::Gray;
pub use pose::{Pinhole, TagPose};

/// A place in a picture, column and row in px, or a direction there.
type Point = [f64; 2];

#[cfg(test)]
mod tests;
