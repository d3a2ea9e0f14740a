//! The result of a recording.

#[cfg(feature = "tools")]
use jde_log::Gap;
use serde::Serialize;

use crate::failure::Failure;

/// A gap in words, where nothing is recorded.
#[cfg(not(feature = "tools"))]
type Gap = String;

/// The result of a recording.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct RecordingSummary {
    /// The file. With conditions, the name from which the numbered names are derived.
    pub(crate) file: String,
    /// The files written for conditions; `None` if there are no conditions.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) files: Option<Vec<RecordedFile>>,
    /// The files that the recording is split into.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) parts: Option<RecordedParts>,
    /// Messages that were dropped from memory before the time to keep them had passed.
    #[serde(skip_serializing_if = "is_zero")]
    pub(crate) short: u64,
    /// Messages in the recording.
    pub(crate) kept: u64,
    /// Values and events that are missing in it.
    pub(crate) lost: u64,
    /// Its size, bytes.
    pub(crate) bytes: u64,
    /// The error that ended the writing, if any.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) trouble: Option<String>,
}

/// The files that a recording is split into.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct RecordedParts {
    /// The name of the first file.
    pub(crate) first: String,
    /// The name of the last file.
    pub(crate) last: String,
    /// How many files were written.
    pub(crate) count: u64,
    /// How many files were deleted, those of earlier recordings included.
    pub(crate) deleted: u64,
    /// Files that should have been deleted and remain.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub(crate) left: Vec<PartLeft>,
    /// The first times of which no file has anything.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub(crate) gaps: Vec<Gap>,
    /// The number of further ones.
    #[serde(skip_serializing_if = "is_zero")]
    pub(crate) more_gaps: u64,
}

/// A file that should have been deleted and remains.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct PartLeft {
    /// The name of the file.
    pub(crate) file: String,
    /// Why it remains.
    pub(crate) reason: String,
}

/// A file written for a condition.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct RecordedFile {
    /// The name of the file.
    pub(crate) file: String,
    /// The condition that became true.
    pub(crate) reason: String,
    /// When it became true, s since the application's start.
    pub(crate) time_s: f64,
    /// How often conditions became true during the file's time.
    pub(crate) fired: u64,
    /// Messages in the file.
    pub(crate) kept: u64,
    /// Messages of its time that are missing.
    pub(crate) lost: u64,
    /// Its size, bytes.
    pub(crate) bytes: u64,
    /// The error that ended it too soon, if any.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) trouble: Option<String>,
}

impl RecordingSummary {
    /// Checks that the recording was written to its end, without a gap.
    ///
    /// # Errors
    /// The disk failed or was full.
    pub(crate) fn check_complete(self) -> Result<(), Failure> {
        let file = self.file;
        let gap = self.parts.and_then(|parts| parts.gaps.into_iter().next());
        match (self.trouble, gap) {
            (Some(error), _) => Err(Failure::Broken(format!("{file} ends too soon: {error}"))),
            (None, Some(gap)) => Err(Failure::Broken(format!("{file} has a gap: {gap}"))),
            (None, None) => Ok(()),
        }
    }
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde requires a reference")]
fn is_zero(number: &u64) -> bool {
    *number == 0
}
