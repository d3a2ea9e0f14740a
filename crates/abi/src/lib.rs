//! The C ABI between the host and its plugins: versioned tables, and a checked way to read them.
//!
//! [`raw`] holds the tables exactly as they cross the boundary; `include/jde.h` is made from it. [`describe`] holds what a
//! plugin says of itself as ordinary owned Rust, and [`read`] is the one door between the two: it checks every table before
//! anything believes it; [`table`] is how tables of different minor versions meet; [`state`] and [`inspect`] are the host's ends of what schemas save and of
//! what they say of their modulations; [`mod@unit`] is which
//! units there are. This crate loads nothing, starts nothing and depends on nothing.

pub mod describe;
pub mod inspect;
pub mod raw;
pub mod read;
pub mod state;
pub mod table;
pub mod unit;
