//! Pictures for schemas, from cameras, and from files in place of a camera.

mod calibration;
mod feed;
mod files;
mod format;
mod linux;
mod v4l2;

pub use files::Files;
pub use v4l2::V4l2;

jde_schema::export!(
    "camera",
    "Pictures of Video4Linux2 cameras, and of files.",
    [V4l2, Files]
);
