//! How long the values of an export are valid.

use serde::{Deserialize, Serialize};

/// How long a value of an export is valid without a newer one (R19).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Validity {
    /// For some of the periods that the application states for the schema.
    #[default]
    Periods,
    /// For this time, ns.
    Time(u64),
    /// Until it is replaced or retracted: a map, a mission.
    Lasting,
}

impl Validity {
    /// Returns it as [`crate::raw::Port`] states it.
    #[must_use]
    pub fn to_ns(self) -> u64 {
        match self {
            Self::Periods => 0,
            Self::Time(ns) => ns,
            Self::Lasting => crate::raw::LASTING,
        }
    }

    /// Returns what a [`crate::raw::Port`] states.
    #[must_use]
    pub fn from_ns(ns: u64) -> Self {
        match ns {
            0 => Self::Periods,
            crate::raw::LASTING => Self::Lasting,
            ns => Self::Time(ns),
        }
    }
}
