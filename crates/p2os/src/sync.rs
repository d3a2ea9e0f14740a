//! The first three packets of a connection, and what the robot calls itself in its answer to the third.

use crate::wire::{packet, record, record_of};
use crate::{Error, Packet};

/// A step of synchronisation; the robot echoes each, and adds its names to the third.
///
/// Byte for byte these are a PULSE, OPEN and CLOSE without argument: only the state of the connection tells
/// which is meant.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sync {
    /// `00`.
    Zero,
    /// `01`.
    One,
    /// `02`.
    Two,
}

record! {
    /// What a robot answers to [`Sync::Two`]: who it is.
    #[derive(Clone, Debug, Default, PartialEq, Eq)]
    Names {
        /// Its own name, such as a number on its back.
        name: String,
        /// Its class: `Pioneer`.
        class: String,
        /// Its subclass, which is its model: `p3dx`.
        subclass: String,
    }
}

impl Sync {
    /// The packet that a client sends, and a robot echoes.
    #[must_use]
    pub fn to_packet(self) -> Packet {
        let id = match self {
            Self::Zero => 0,
            Self::One => 1,
            Self::Two => 2,
        };
        Packet::new(&[id]).expect("one byte is a payload")
    }

    /// Which step a packet without argument is; `None` for anything else.
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
    /// The answer to [`Sync::Two`].
    ///
    /// # Errors
    /// If the names are too long for a packet.
    pub fn to_packet(&self) -> Result<Packet, Error> {
        packet(2, self)
    }

    /// The names in the answer to [`Sync::Two`].
    ///
    /// # Errors
    /// If it is no such answer, or a name does not end.
    pub fn from_packet(packet: &Packet) -> Result<Self, Error> {
        record_of("answer to the third synchronisation", 2, packet)
    }
}
