//! The failure of a call of a schema.

use core::fmt;

use jde_abi::raw;

/// The failure of a call of a schema.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Failure {
    /// The code that the call returned: `FAILED`, `PANICKED` or another code of the ABI.
    pub code: i32,
    /// The message of the error or the panic.
    pub reason: String,
}

impl Failure {
    /// Returns whether the call only said that an import has no value, which is no fault (R19).
    #[must_use]
    pub fn lacks_value(&self) -> bool {
        self.code == raw::NO_VALUE
    }

    /// Returns whether the call panicked.
    #[must_use]
    pub fn panicked(&self) -> bool {
        self.code == raw::PANICKED
    }
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "the call failed with code {}: {}", self.code, self.reason)
    }
}

impl core::error::Error for Failure {}
