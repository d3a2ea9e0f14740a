//! Panels: their bytes, their limits, the pen that draws them, and the gestures that they take.

mod bytes;
mod checks;
mod common;
mod limits;
mod pen;
mod takes;
