//! The protocol: packets and commands, sessions, models.

mod codecs;
mod common;
mod models;
mod properties;
mod robot;
mod session;
