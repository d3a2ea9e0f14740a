//! Why there is no recording.

use std::io;
use std::path::PathBuf;

/// Why a recording cannot be begun.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// There is a file of that name.
    #[error("{} exists already, and a recording is not written over unless that is asked for", .0.display())]
    Exists(PathBuf),
    /// It is to be written over, and another recording writes it.
    #[error("{} is being written by another recording", .0.display())]
    Written(PathBuf),
    /// The file cannot be made or its beginning not written.
    #[error("cannot record to {}: {error}", path.display())]
    Create {
        /// Which.
        path: PathBuf,
        /// Why.
        error: io::Error,
    },
    /// The machine refused a thread.
    #[error("the system refuses a thread for the recording: {0}")]
    Thread(io::Error),
}
