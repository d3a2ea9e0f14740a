//! Side-by-side measurement, and how its results are evaluated and shown. This crate does not depend on what
//! is measured or on the yardsticks, so its tests need neither.

pub mod figure;
pub mod grid;
pub mod page;
pub mod pairs;
pub mod table;
