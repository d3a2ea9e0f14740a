//! A served world, driven by a client that knows only the protocol.

mod common;
mod driving;
mod sessions;
