//! Ports over real sockets and pseudo-terminals.

mod common;
mod serial;
mod tcp;
