//! The description of a guard.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::{Type, shared};

/// What a guard judges, and by what.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Guard {
    /// The index of the export by whose newest value it judges.
    pub state: usize,
    /// The type of the commands.
    #[serde(with = "shared")]
    pub command: Arc<Type>,
}
