//! The one error of authors: anything that can be said in words.

/// Why a call of a schema failed: made by `?` from a text or any error of the standard kind. The host makes the schema Faulted
/// and shows the text with those of its sources.
pub type Error = Box<dyn core::error::Error + Send + Sync>;

/// What the calls of a schema return.
pub type Result<T = (), E = Error> = core::result::Result<T, E>;

/// The text of an error and of what caused it.
pub(crate) fn words(error: &Error) -> String {
    let mut words = error.to_string();
    let mut source = error.source();
    while let Some(cause) = source {
        words = format!("{words}: {cause}");
        source = cause.source();
    }
    words
}
