//! What schemas that see share: the pixels of an image, ranges of colour, connected components of pixels, and
//! the way from a pixel to a direction and to a point on the floor.
//!
//! Pure functions of their arguments, but for the files of calibrations. The crate opens no camera and steers nothing.

mod blob;
mod calibration;
mod camera;
mod color;
mod distortion;
mod geometry;
mod mount;
mod pixels;
mod ports;

pub use blob::{Blobs, Component, PixelRun};
pub use calibration::{parse_calibration, read_calibration};
pub use camera::{CameraModel, Observation};
pub use color::{ColorRange, Hsv};
pub use geometry::CameraGeometry;
pub use mount::CameraMount;
pub use pixels::{Pixels, UnknownPixels};
pub use ports::CameraPorts;

#[cfg(test)]
mod tests;
