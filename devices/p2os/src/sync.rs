//! The first three packets of a connection, and the robot's names in its reply to the third.

use crate::wire::{packet, record, record_of};
use crate::{Error, Packet};

/// A step of synchronisation. The robot echoes each, and appends its names to the third.
///
/// The bytes are those of PULSE, OPEN and CLOSE without argument: only the state of the connection
/// distinguishes them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SyncStep {
    /// `00`.
    Zero,
    /// `01`.
    One,
    /// `02`.
    Two,
}

record! {
    /// The names of a robot, in its reply to [`SyncStep::Two`].
    #[derive(Clone, Debug, Default, PartialEq, Eq)]
    Names {
        /// Its own name, for example a number on its back.
        name: String,
        /// Its class: `Pioneer`.
        class: String,
        /// Its subclass, which is its model: `p3dx`.
        subclass: String,
    }
}

impl SyncStep {
    /// Returns the packet that a client sends and a robot echoes.
    #[must_use]
    pub fn to_packet(self) -> Packet {
        let id = match self {
            Self::Zero => 0,
            Self::One => 1,
            Self::Two => 2,
        };
        Packet::new(&[id]).expect("one byte is a payload")
    }

    /// Returns the step of a packet without argument; `None` for any other packet.
    #[must_use]
    pub fn from_packet(packet: &Packet) -> Option<Self> {
        match packet.payload() {
            [0] => Some(Self::Zero),
            [1] => Some(Self::One),
            [2] => Some(Self::Two),
            _ => None,
        }
    }
}

impl Names {
    /// Encodes the reply to [`SyncStep::Two`].
    ///
    /// # Errors
    /// If the names are too long for a packet.
    pub fn to_packet(&self) -> Result<Packet, Error> {
        packet(2, self)
    }

    /// Decodes the reply to [`SyncStep::Two`].
    ///
    /// # Errors
    /// If it is not such a reply, or a name is not terminated.
    pub fn from_packet(packet: &Packet) -> Result<Self, Error> {
        record_of("reply to the third synchronisation", 2, packet)
    }
}
