//! The output of a session for its owner: its state, and the robot's data.

use crate::{Config, Names, Reading, Sip};

/// The state of a session.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum State {
    /// There is no connection, or it was closed.
    Idle,
    /// The synchronisation is in progress.
    Syncing,
    /// The robot has sent its names, and is being switched on.
    Opening(Names),
    /// The robot can be driven.
    Connected(Names),
    /// The robot is silent or sent invalid data. Start again with a new connection.
    Lost(String),
    /// This session cannot drive the robot; a person must correct the configuration.
    Refused(String),
}

/// Data from a robot.
#[derive(Clone, Debug, PartialEq)]
pub enum Event {
    /// Its state.
    Sip(Box<Sip>),
    /// Its configuration.
    Config(Box<Config>),
    /// A sweep of the laser.
    Laser(Vec<Reading>),
    /// Ticks of the wheels since the first count, without wrapping.
    Encoders {
        /// Left wheel.
        left: i64,
        /// Right wheel.
        right: i64,
    },
    /// The angles of the head: measured, or computed from the commands if the head cannot reply.
    Head {
        /// To the left, rad.
        pan: f64,
        /// Down, rad.
        tilt: f64,
    },
    /// The description of a problem that does not end the session.
    Warning(String),
}

impl State {
    /// Returns whether the robot can be driven.
    #[must_use]
    pub fn is_connected(&self) -> bool {
        matches!(self, Self::Connected(_))
    }
}
