//! How things are measured side by side, and judged and shown. It knows neither what is measured nor what that is compared with, so that
//! its tests need none of either.

pub mod figure;
pub mod grid;
pub mod page;
pub mod pairs;
pub mod table;
