//! What a session tells whoever drives it: its state, and what the robot said.

use crate::{Config, Names, Reading, Sip};

/// How a session stands.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum State {
    /// There is no connection, or it was closed.
    Idle,
    /// It says hello.
    Syncing,
    /// The robot has said who it is, and is being switched on.
    Opening(Names),
    /// It drives.
    Connected(Names),
    /// The robot is silent or said what no robot would; begin again over a new connection.
    Lost(String),
    /// The robot is one that this session cannot drive; a person must mend it.
    Refused(String),
}

/// What a robot said.
#[derive(Clone, Debug, PartialEq)]
pub enum Event {
    /// How it is.
    Sip(Box<Sip>),
    /// What it is set to.
    Config(Box<Config>),
    /// A sweep of the laser.
    Laser(Vec<Reading>),
    /// Ticks of the wheels since they were first heard, without wrapping.
    Encoders {
        /// Of the left wheel.
        left: i64,
        /// Of the right wheel.
        right: i64,
    },
    /// Where the head looks, rad to the left and rad down; by its own word, or by what it was told if it
    /// cannot answer.
    Head {
        /// To the left.
        pan: f64,
        /// Down.
        tilt: f64,
    },
    /// Something is off, in words; the session goes on.
    Warning(String),
}

impl State {
    /// Whether the robot drives.
    #[must_use]
    pub fn is_connected(&self) -> bool {
        matches!(self, Self::Connected(_))
    }
}
