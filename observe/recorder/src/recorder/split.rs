//! Recordings in parts: when one file ends and the next begins, and how much of them is kept.

use std::collections::BTreeMap;
use std::path::PathBuf;

use jde_board::Nanos;

use jde_log::part::Gap;

/// How to record in parts: `drive.mcap`, then `drive-001.mcap`, `drive-002.mcap` and so on. Each file can be
/// read alone, and [`jde_log::Recording`] reads all of them as one recording.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SplitOptions {
    /// When a file ends.
    pub part_size: PartSize,
    /// The upper limit in bytes of all files of that name, including those of earlier recordings. The oldest
    /// are deleted. Without a limit none is deleted.
    pub max_total_bytes: Option<u64>,
}

/// The size of a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PartSize {
    /// This many bytes, and at most one chunk of about 1 MB more. The values that are repeated at the
    /// beginning are not counted.
    Bytes(u64),
    /// This much time of the application's clock, in ns.
    Time(Nanos),
}

/// The files of a recording in parts, or of one that went on in others after the disk had failed.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Parts {
    /// The first file that was written.
    pub first: PathBuf,
    /// The last file that was written.
    pub last: PathBuf,
    /// The number of files that were written.
    pub count: u64,
    /// The number of files that were deleted since, including those of earlier recordings.
    pub deleted: u64,
    /// The files that should have been deleted and remain, each with the reason.
    pub undeleted: BTreeMap<PathBuf, String>,
    /// The first times of which no file has anything, in their order.
    pub gaps: Vec<Gap>,
    /// The number of further ones.
    pub more_gaps: u64,
}
