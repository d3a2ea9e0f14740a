//! The TCP protocol of Player servers, version 3, as a client speaks it, without I/O: robots behind Player,
//! and the robots of Stage.
//!
//! There are no sockets, threads or clocks here: the caller supplies the bytes and the time. A [`Session`]
//! asks a server for its devices, subscribes to those that a mobile robot has, decodes their data and
//! commands the base and the head.
//!
//! Source: the interface definitions of Player 3.1 (`libplayerinterface`), whose messages are XDR (RFC 4506)
//! behind a header of 40 bytes. Player's units are those of jde: m, rad, x ahead, y to the left.

mod data;
mod device;
mod error;
mod geometry;
mod message;
mod session;
mod wire;

pub use data::{Base, Head, Power, Scan};
pub use device::{Device, DeviceError, Interface};
pub use error::Error;
pub use geometry::Mount;
pub use message::{HEADER, Kind, MAX_BODY, Message, Receiver};
pub use session::{Choice, Event, HeadSetpoint, Laser, Options, Ring, Robot, Session, Setpoint, State};
