//! What hinders a recording, in words.

use std::fmt::{self, Display};
use std::path::PathBuf;

use jde_log::part::Gap;

/// Called by the writing thread with what hinders the recording.
pub type OnTrouble = Box<dyn FnMut(&Trouble) + Send>;

/// What hinders a recording, or does so no longer. As text it continues "the recording drive.mcap".
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Trouble {
    /// The pipe or device accepts no more, or there is no name for a new part, and the recording has ended.
    Ended {
        /// What the system said.
        reason: String,
    },
    /// The disk accepts no more at present. A new part is tried until it does.
    Interrupted {
        /// What the system said.
        reason: String,
        /// How many gaps have not been reported since the last one that was.
        unreported: u64,
    },
    /// The recording goes on after a gap.
    Resumed(Gap),
    /// An old part cannot be deleted. It is tried again.
    Undeleted {
        /// The part.
        path: PathBuf,
        /// What the system said.
        reason: String,
    },
}

impl Display for Trouble {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Ended { reason } => write!(out, "ends early, and the run goes on: {reason}"),
            Self::Interrupted { reason, unreported } => {
                write!(
                    out,
                    "is interrupted, and goes on in a new part when the disk accepts one: {reason}"
                )?;
                match unreported {
                    0 => Ok(()),
                    count => write!(out, " (and {count} more times since the last report)"),
                }
            }
            Self::Resumed(gap) => write!(out, "goes on; {gap}"),
            Self::Undeleted { path, reason } => {
                let path = path.display();
                write!(
                    out,
                    "keeps {path}, which cannot be deleted and is tried again: {reason}"
                )
            }
        }
    }
}
