//! What is wrong in a file that a person wrote, and where. It stops nothing by itself.

use std::fmt;
use std::path::PathBuf;

/// One error or doubtful statement in a file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Fault {
    /// The file: a world, a map or the map's image.
    pub file: PathBuf,
    /// The line, from 1; none when no line applies: the file could not be read, or is an image that is no text.
    pub line: Option<usize>,
    /// What is wrong, what was expected, and what to do.
    pub message: String,
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.line {
            Some(line) => write!(f, "{}:{line}: {}", self.file.display(), self.message),
            None => write!(f, "{}: {}", self.file.display(), self.message),
        }
    }
}
