//! Recordings that go on for ever: when one file ends and the next begins, and how much is kept of them.

use std::collections::BTreeSet;
use std::path::PathBuf;

use jde_board::Nanos;

/// Writing one file after the other: of `drive.mcap`, `drive-001.mcap`, `drive-002.mcap`. Each can be read alone, and
/// [`crate::Recording`] reads them as one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Split {
    /// When a file ends.
    pub every: Every,
    /// Most bytes of all files of that name, also of recordings before; the oldest are deleted. Without it none is.
    pub keep: Option<u64>,
}

/// How much goes into a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Every {
    /// So many bytes, and at most one chunk of about 1 MB more; what it repeats at its beginning is not counted.
    Bytes(u64),
    /// So much of the application's time, ns.
    Time(Nanos),
}

/// The files of a recording in parts.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Parts {
    /// The first that was written.
    pub first: PathBuf,
    /// The last.
    pub last: PathBuf,
    /// How many were written.
    pub count: u64,
    /// How many were deleted since, those of recordings before included.
    pub deleted: u64,
    /// Those that were to be deleted and are there, because another recording writes them.
    pub left: BTreeSet<PathBuf>,
}
