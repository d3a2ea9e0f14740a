//! Reports on recordings without a screen: pictures of a robot's path, the schemas' states and the values of
//! variables over time, and a page with all of these. And the page of an experiment.
//!
//! The crate reads recordings and draws. It runs no schema, uses no network and prints nothing.

// Charts and pages use parts of the drawings that drives do not.
#![cfg_attr(
    not(feature = "recordings"),
    allow(dead_code, reason = "only recordings use it")
)]

#[cfg(feature = "recordings")]
mod analysis;
#[cfg(feature = "recordings")]
mod chart;
#[cfg(feature = "recordings")]
mod document;
mod drawing;
#[cfg(feature = "recordings")]
pub mod experiment;
mod map;
#[cfg(feature = "recordings")]
mod page;
mod picture;
mod round;
#[cfg(feature = "recordings")]
mod sheet;
#[cfg(all(test, feature = "recordings"))]
mod tests;
mod text;

#[cfg(feature = "recordings")]
pub use analysis::{Analysis, Number, Series, Wanted};
#[cfg(feature = "recordings")]
pub use map::FailurePlace;
pub use map::{Drive, Obstacle, Paint, PathPoint, RobotPath, Takeover, Target};
#[cfg(feature = "recordings")]
pub use page::{columns, page};
pub use picture::{Picture, PictureError};
#[cfg(feature = "recordings")]
pub use sheet::{Numbers, SIDES, Size};
pub use text::format_size;
