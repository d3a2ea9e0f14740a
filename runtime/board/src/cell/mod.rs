//! The cells of the variables: where the bytes are, and how readers and writers are kept from conflicting.
//!
//! There are two kinds. Both are one contiguous region of words and blocks that refer to each other by
//! number, never by address:
//! - [`Ring`]: small values of one writer. Readers copy, and retry if the writer overtook them.
//! - [`Pinned`]: all other values. Readers pin the newest value and read it in place. Writers fill a slot
//!   that is not in use.
//!
//! Cells contain bytes and stamps only. They use no types, names, clocks or locks.

#![cfg_attr(
    not(loom),
    allow(
        unreachable_pub,
        reason = "the models of tests/loom.rs see this module, no other code does"
    )
)]

mod aligned;
mod pinned;
mod region;
mod ring;
mod version_check;

pub use aligned::Aligned;
#[cfg(loom)]
pub use pinned::Withdrawn;
pub use pinned::{Claim, Pin, Pinned};
pub use region::Region;
pub use ring::Ring;
pub use version_check::VersionCheck;

/// What a cell stores beside a value.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SlotStamp {
    /// Counts the values from 1; 0 is the initial value.
    pub sequence: u64,
    /// Time of the value, in nanoseconds.
    pub time: u64,
    /// The id of its writer.
    pub writer: u32,
    /// The last instant at which it is valid or in force, in nanoseconds.
    pub valid_until: u64,
}
