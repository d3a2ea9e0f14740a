//! Where a recording ends too early, and whether it is only not finished.

use std::fmt;
use std::fs::{File, TryLockError};
use std::path::Path;

/// The beginning of what is wrong with a file that grows still, and with no other one that is being written.
pub(super) const CUT_OFF: &str = "it was cut off";

/// Where a recording ends too early.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Damage {
    /// The number of intact bytes from the beginning of the file. `None` for a database, which has no order of its bytes.
    pub offset: Option<u64>,
    /// What is wrong after them.
    pub reason: String,
}

impl Damage {
    /// The reason of a file that a recorder still writes.
    pub const UNFINISHED: &str = "it is still being written";

    /// Whether the file ends there because a recorder still writes it.
    #[must_use]
    pub fn is_unfinished(&self) -> bool {
        self.reason.ends_with(Self::UNFINISHED)
    }

    /// Says where the recording ends, and why: "it ends too soon, at byte 17: it was cut off".
    #[must_use]
    pub fn sentence(&self) -> String {
        match self.is_unfinished() {
            true => Self::UNFINISHED.to_owned(),
            false => format!("it ends too soon, {self}"),
        }
    }
}

/// Where and what: "at byte 17: it was cut off".
impl fmt::Display for Damage {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.offset {
            Some(offset) => write!(f, "at byte {offset}: {}", self.reason),
            None => write!(f, "after what can be read: {}", self.reason),
        }
    }
}

/// Whether a recorder writes a file: it has locked it. Without locks this is not known.
pub(super) fn is_being_written(path: &Path) -> bool {
    File::open(path).is_ok_and(|file| matches!(file.try_lock_shared(), Err(TryLockError::WouldBlock)))
}
