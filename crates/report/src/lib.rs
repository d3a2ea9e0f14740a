//! What a recording comes to, for people without a screen: pictures of where a robot drove, who acted when and how variables went,
//! and a page that tells all of it.
//!
//! It reads recordings and draws; it runs nothing, asks nobody over the network and prints nothing.

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
