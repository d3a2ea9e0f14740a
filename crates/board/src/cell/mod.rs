//! The cells beneath the variables: where the bytes are, and how readers and writers keep out of each other's way.
//!
//! Two kinds, both one contiguous region of words and blocks that refer to each other by number and never by address:
//! - [`Ring`]: small values of one writer. Readers copy, and try again if the writer overtook them.
//! - [`Pinned`]: everything else. Readers pin the newest value and read it in place; writers fill a slot that nobody holds.
//!
//! Cells know bytes and stamps only: no types, no names, no clocks, no locks.

#![cfg_attr(
    not(loom),
    allow(
        unreachable_pub,
        reason = "the models of tests/loom.rs see this module, nobody else does"
    )
)]

mod aligned;
mod glance;
mod pinned;
mod region;
mod ring;

pub use aligned::Aligned;
pub use glance::Glance;
#[cfg(loom)]
pub use pinned::Withdrawn;
pub use pinned::{Claim, Pin, Pinned};
pub use region::Region;
pub use ring::Ring;

/// What a cell keeps beside a value.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Mark {
    /// Counts the values from 1; 0 is the one from before the first.
    pub sequence: u64,
    /// Time of the value, ns.
    pub time: u64,
    /// Who wrote it.
    pub writer: u32,
    /// When it stops being in force, ns.
    pub valid_until: u64,
}
