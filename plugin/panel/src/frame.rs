//! A drawing of a panel, as its viewers receive it.

use std::time::Duration;

use crate::List;

/// The most drawings of a panel per second: more is not visible.
pub const MAX_RATE: f64 = 30.0;

/// What a panel showed at one instant.
#[derive(Clone, Debug, PartialEq)]
pub struct PanelFrame {
    /// Counts the drawings of this panel from 1.
    pub sequence: u64,
    /// When it was drawn, ns since the application's start.
    pub time: u64,
    /// How long the drawing took, in machine time.
    pub took: Duration,
    /// Failed drawings of this panel so far.
    pub failed: u64,
    /// The widgets, or why there is nothing to show.
    pub list: Result<List, String>,
}
