//! The error type of schemas: any error that has a message.

/// Why a call of a schema failed. `?` converts a text or any standard error into it. The host makes the
/// schema Faulted and shows the message together with the messages of its sources.
pub type Error = Box<dyn core::error::Error + Send + Sync>;

/// The result of a schema's calls.
pub type Result<T = (), E = Error> = core::result::Result<T, E>;

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
