//! The description of a guard.

use std::sync::Arc;

use super::Type;

/// What a guard judges, and by what.
#[derive(Clone, Debug, PartialEq)]
pub struct Guard {
    /// The index of the export by whose newest value it judges.
    pub state: usize,
    /// The type of the commands.
    pub command: Arc<Type>,
}
