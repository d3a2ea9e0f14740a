//! Areas of colour in pictures: a perceptive schema finds them and where they are on the floor, and a motor
//! schema drives to the nearest.

mod approach;
mod color;
mod colors;
mod panel;

pub use approach::Approach;
pub use color::Color;
pub use colors::{ColorLimits, Colors};

jde_schema::export!(
    "see",
    "Finds areas of colour in pictures, and drives to them.",
    [Color, Approach]
);

#[cfg(test)]
mod tests;
