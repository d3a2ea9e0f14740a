//! The protocol: packets and commands, sessions, models.

mod checks;
mod codecs;
mod common;
mod models;
mod noise;
mod properties;
mod robot;
mod session;
