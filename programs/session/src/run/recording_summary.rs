//! The result of a recording.

use serde::Serialize;

use crate::failure::Failure;

/// The result of a recording.
#[derive(Clone, Debug, Serialize)]
pub struct RecordingSummary {
    /// The file. With conditions, the name from which the numbered names are derived.
    pub file: String,
    /// The files written for conditions; `None` if there are no conditions.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub files: Option<Vec<RecordedFile>>,
    /// The files that the recording is split into.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub parts: Option<RecordedParts>,
    /// Messages that were dropped from memory before the time to keep them had passed.
    #[serde(skip_serializing_if = "is_zero")]
    pub short: u64,
    /// Messages in the recording.
    pub kept: u64,
    /// Values and events that are missing in it.
    pub lost: u64,
    /// Its size, bytes.
    pub bytes: u64,
    /// The error that ended the writing, if any.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub trouble: Option<String>,
}

/// The files that a recording is split into.
#[derive(Clone, Debug, Serialize)]
pub struct RecordedParts {
    /// The name of the first file.
    pub first: String,
    /// The name of the last file.
    pub last: String,
    /// How many files were written.
    pub count: u64,
    /// How many files were deleted, those of earlier recordings included.
    pub deleted: u64,
    /// Files that should have been deleted and remain.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub left: Vec<PartLeft>,
    /// The first times of which no file has anything.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub gaps: Vec<RecordedGap>,
    /// The number of further ones.
    #[serde(skip_serializing_if = "is_zero")]
    pub more_gaps: u64,
}

/// A time of which no file has anything.
#[derive(Clone, Debug, Serialize)]
pub struct RecordedGap {
    /// When it begins, ns since the application's start.
    pub from: u64,
    /// When it ends, ns; `None` if it does not.
    pub until: Option<u64>,
    /// Messages that are missing.
    pub lost: u64,
    /// Why.
    pub reason: String,
    /// All of this in words.
    #[serde(skip)]
    pub text: String,
}

/// A file that should have been deleted and remains.
#[derive(Clone, Debug, Serialize)]
pub struct PartLeft {
    /// The name of the file.
    pub file: String,
    /// Why it remains.
    pub reason: String,
}

/// A file written for a condition.
#[derive(Clone, Debug, Serialize)]
pub struct RecordedFile {
    /// The name of the file.
    pub file: String,
    /// The condition that became true.
    pub reason: String,
    /// When it became true, s since the application's start.
    pub time_s: f64,
    /// How often conditions became true during the file's time.
    pub fired: u64,
    /// Messages in the file.
    pub kept: u64,
    /// Messages of its time that are missing.
    pub lost: u64,
    /// Its size, bytes.
    pub bytes: u64,
    /// The error that ended it too soon, if any.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub trouble: Option<String>,
}

impl RecordingSummary {
    /// Checks that the recording was written to its end, without a gap.
    ///
    /// # Errors
    /// The disk failed or was full.
    pub fn check_complete(self) -> Result<(), Failure> {
        let file = self.file;
        let gap = self.parts.and_then(|parts| parts.gaps.into_iter().next());
        match (self.trouble, gap) {
            (Some(error), _) => Err(Failure::Broken(format!("{file} ends too soon: {error}"))),
            (None, Some(gap)) => Err(Failure::Broken(format!("{file} has a gap: {}", gap.text))),
            (None, None) => Ok(()),
        }
    }
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde requires a reference")]
fn is_zero(number: &u64) -> bool {
    *number == 0
}
