//! How a call of a schema failed.

use core::fmt;

use jde_abi::raw;

/// How a call of a schema failed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Failure {
    /// What it returned: `FAILED`, `PANICKED` or another code of the ABI.
    pub code: i32,
    /// The reason it gave.
    pub reason: String,
}

impl Failure {
    /// Whether it panicked.
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
