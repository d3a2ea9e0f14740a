//! The error of a recording that cannot start.

use std::io;
use std::path::PathBuf;

/// Why a recording cannot start.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// A file of that name exists.
    #[error("{} exists already; it is only overwritten on request", .0.display())]
    Exists(PathBuf),
    /// The file that `overwrite` names is being written by another recording.
    #[error("{} is being written by another recording", .0.display())]
    Written(PathBuf),
    /// The file cannot be created, or its header cannot be written.
    #[error("cannot record to {}: {error}", path.display())]
    Create {
        /// The path of the file.
        path: PathBuf,
        /// The cause.
        error: io::Error,
    },
    /// The system refuses a thread.
    #[error("the system refuses a thread for the recording: {0}")]
    Thread(io::Error),
}
