//! Variables: their values, types, grants, watches, and the memory that other processes share.

#[path = "../common/mod.rs"]
mod common;

mod board;
mod finite;
mod gate;
mod loans;
mod shared;
mod typed;
mod validity;
mod value;
mod watch;
