//! The protocol: messages, sessions, and bytes that are not the protocol.

mod checks;
mod messages;
mod noise;
mod server;
mod session;
