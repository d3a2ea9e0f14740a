//! What came of an order.

use std::time::Instant;

/// What came of something that was asked of the application.
#[derive(Clone, Debug)]
pub(crate) struct Notice {
    /// In words.
    pub(crate) text: String,
    /// It was refused or lost.
    pub(crate) failed: bool,
    /// When it was known.
    pub(crate) at: Instant,
}
