//! The C ABI between the host and its plugins: versioned tables, and functions that check and read them.
//!
//! - [`raw`] contains the tables exactly as they cross the boundary. `include/jde.h` is generated from it.
//! - [`describe`] contains the description of a plugin as owned Rust values.
//! - [`read`] converts the tables to descriptions, and checks every table before it is used.
//! - [`mod@write`] converts descriptions to tables.
//! - [`host`] makes the table of a host from its methods.
//! - [`table`] reads and writes tables of different minor versions.
//! - [`state`], [`inspect`], [`guard`] and [`lists`] are the host's sides of saving a memory, of inspecting
//!   modulations, of judging commands and of ports that an application lists.
//! - [`mod@unit`] defines the known units.
//! - [`finite`] finds NaNs and infinities in values.
//!
//! This crate loads nothing, starts nothing, and uses no library but serde, for the descriptions.

pub mod describe;
pub mod finite;
pub mod guard;
pub mod host;
pub mod inspect;
pub mod lists;
pub mod raw;
pub mod read;
pub mod state;
pub mod table;
pub mod unit;
pub mod write;
