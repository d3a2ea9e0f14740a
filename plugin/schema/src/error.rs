//! The error type of schemas: any error that has a message, and the one that is no fault.

use core::fmt;

/// Why a call of a schema failed. `?` converts a text or any standard error into it. The host makes the
/// schema Faulted, unless it is the [`NoValue`] of a check or an iteration, and shows the message together with the messages of its sources.
pub type Error = Box<dyn core::error::Error + Send + Sync>;

/// The result of a schema's calls.
pub type Result<T = (), E = Error> = core::result::Result<T, E>;

/// An import has no value: nothing has been published yet, or the value has ended. No fault: the iteration or the check
/// that returns it ends there, and a motor schema is not READY (R19).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NoValue {
    /// The name of the import.
    pub import: &'static str,
}

impl fmt::Display for NoValue {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "import `{}` has no value", self.import)
    }
}

impl core::error::Error for NoValue {}

/// Returns the message of an error, followed by those of its sources.
pub(crate) fn message(error: &Error) -> String {
    let mut text = error.to_string();
    let mut source = error.source();
    while let Some(cause) = source {
        text = format!("{text}: {cause}");
        source = cause.source();
    }
    text
}
