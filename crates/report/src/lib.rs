//! Reports on recordings without a screen: pictures of a robot's path, the schemas' states and the values of
//! variables over time, and a page with all of these.
//!
//! The crate reads recordings and draws. It runs no schema, uses no network and prints nothing.

mod analysis;
mod chart;
mod drawing;
mod map;
mod page;
mod picture;
mod sheet;
#[cfg(test)]
mod tests;

pub use analysis::{Analysis, Number, Series, Wanted};
pub use map::{Drive, Obstacle, PathPoint, RobotPath, Takeover, Target};
pub use page::{columns, page};
pub use picture::{Picture, PictureError};
pub use sheet::{SIDES, Size};
