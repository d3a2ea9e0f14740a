//! Shared variables: typed, stamped, never torn.
//!
//! A [`Board`] holds the latest value of everything that a schema exports, and of every modulation and command. Writers never
//! wait; readers never see half a value; a command takes effect only while its writer holds a grant (R7). Keeps no history,
//! opens no socket, knows no schema: that is the business of the crates above.

#[cfg(loom)]
pub mod cell;
#[cfg(not(loom))]
mod cell;
mod sync;

#[cfg(not(loom))]
mod bell;
#[cfg(not(loom))]
mod board;
#[cfg(not(loom))]
mod declaration;
#[cfg(not(loom))]
mod error;
#[cfg(not(loom))]
pub mod finite;
#[cfg(not(loom))]
mod nearest;
#[cfg(not(loom))]
mod rate;
#[cfg(not(loom))]
mod reader;
#[cfg(not(loom))]
mod register;
#[cfg(not(loom))]
mod shared;
#[cfg(not(loom))]
mod store;
#[cfg(not(loom))]
pub mod typed;
#[cfg(not(loom))]
pub mod value;
#[cfg(not(loom))]
mod variable;
#[cfg(not(loom))]
mod watch;
#[cfg(not(loom))]
mod writer;

#[cfg(not(loom))]
pub use {
    board::Board,
    declaration::{Access, Declaration, Nanos, Stamp},
    error::{Error, Refused},
    nearest::nearest,
    reader::{Latched, Reader},
    shared::{Mapped, Shared},
    variable::{Variable, VariableStatus},
    watch::Watch,
    writer::{Parted, Writer},
};
