//! The packet protocol of Pioneer robots (P2OS, AROS, ARCOS) and of the simulators that implement it: both
//! ends, without I/O.
//!
//! There are no sockets, serial lines, threads or clocks here: the caller supplies the bytes and the time. A
//! robot or simulator finds [`Packet`]s with a [`Receiver`], decodes [`Command`]s and replies with [`Names`],
//! [`Sip`], [`Config`], [`LaserPacket`], [`Encoders`], [`SerialAux`] and [`SimState`]. A client uses a
//! [`Session`], which does all of that and uses the robot's [`Model`].

mod command;
mod config;
mod encoders;
mod error;
mod head;
mod laser;
mod model;
mod odometer;
mod packet;
mod receiver;
mod serial;
mod session;
mod sip;
mod state;
mod sync;
mod wire;

pub use command::{Argument, Command, ForLaser, Form, SimControl, SimPose, Wheels};
pub use config::Config;
pub use encoders::Encoders;
pub use error::Error;
pub use head::{Focus, HeadCommand, HeadFrame, HeadParser, HeadReply, MAX_ZOOM, UNIT as HEAD_UNIT};
pub use laser::{Assembler, LaserForm, LaserPacket, READINGS, Reading};
pub use model::{Battery, Body, Bumpers, LaserMount, Model, ModelError, Sonars, SpeedLimits, Ticks, Units};
pub use odometer::{Odometer, Pose};
pub use packet::{MAX_PAYLOAD, Packet, checksum};
pub use receiver::{Dropped, MAX_GAP, Receiver};
pub use serial::{AuxPort, SerialAux};
pub use session::{Beams, Event, HeadKind, HeadSetpoint, LaserMode, Options, Session, Setpoint, State};
pub use sip::{Flags, Sip, SonarReading};
pub use state::SimState;
pub use sync::{Names, SyncStep};
