//! How much a timeline keeps.

use crate::record_log::LogLimits;

/// How much a timeline keeps. What is older is forgotten, except that counts and times in states stay exact.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Keep {
    /// The most intervals of each schema's states and of each group's winners.
    pub intervals: usize,
    /// The most marks of all schemas.
    pub marks: usize,
    /// The most switches of each group.
    pub switches: usize,
    /// The records.
    pub records: LogLimits,
    /// Whether the intervals that are kept no more are handed over: see [`Timeline::take_ended`](crate::Timeline::take_ended).
    pub ended: bool,
}

impl Keep {
    /// The present alone. Its memory is that of the hierarchy: about 1 kB for each schema and group.
    pub const PRESENT: Self = Self {
        intervals: 1,
        marks: 0,
        switches: 1,
        records: LogLimits {
            records: 0,
            candidates: 0,
            switches: 0,
        },
        ended: false,
    };

    /// What a window shows of a live run: 20,000 of everything, which is half an hour at ten a second, and of switches some
    /// hours. A schema takes 6 MB at most, and the marks and the records of a run 60 MB.
    pub const LIVE: Self = Self {
        intervals: 20_000,
        marks: 20_000,
        switches: 20_000,
        records: LogLimits {
            records: 20_000,
            candidates: 400_000,
            switches: 20_000,
        },
        ended: false,
    };

    /// Everything: for files.
    pub const ALL: Self = Self {
        intervals: usize::MAX,
        marks: usize::MAX,
        switches: usize::MAX,
        records: LogLimits {
            records: usize::MAX,
            candidates: usize::MAX,
            switches: 0,
        },
        ended: false,
    };
}
