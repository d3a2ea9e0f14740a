//! What does not work, in words.

use std::fmt::Display;

/// What does not work, in words.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Error {
    /// Nothing has this name.
    #[error("{0}")]
    Unknown(String),
    /// A value, a type, a condition or a time does not fit.
    #[error("{0}")]
    Invalid(String),
    /// The application refuses the action.
    #[error("{0}")]
    Refused(String),
    /// The application cannot be loaded or started.
    #[error("{0}")]
    Failed(String),
}

impl Error {
    pub(crate) fn unknown(reason: impl Display) -> Self {
        Self::Unknown(reason.to_string())
    }

    pub(crate) fn invalid(reason: impl Display) -> Self {
        Self::Invalid(reason.to_string())
    }

    pub(crate) fn refused(reason: impl Display) -> Self {
        Self::Refused(reason.to_string())
    }

    pub(crate) fn failed(reason: impl Display) -> Self {
        Self::Failed(reason.to_string())
    }
}
