//! Shared variables: typed, stamped, never torn.
//!
//! A [`Board`] holds the newest value of every export, modulation and command. Writers never wait. Readers
//! never read a torn value. A command takes effect only while its writer holds a grant (R7). The crate
//! keeps no history, opens no sockets and knows no schemas: the crates above do that.

#[cfg(loom)]
pub mod cell;
#[cfg(not(loom))]
mod cell;
mod sync;

#[cfg(not(loom))]
mod board;
#[cfg(not(loom))]
mod declaration;
#[cfg(not(loom))]
mod error;
#[cfg(not(loom))]
#[cfg(not(loom))]
mod notifier;
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
    declaration::{Access, Declaration, LASTING, Nanos, Stamp},
    error::{Error, Refused},
    reader::{Latched, Reader},
    shared::{Mapping, Shared},
    variable::{Variable, VariableStatus},
    watch::Watch,
    writer::{DetachedLoan, Writer},
};
