//! A served world, driven by a client that knows the protocol alone.

mod common;
mod driving;
mod sessions;
