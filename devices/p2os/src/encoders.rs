//! The counts of the wheels' encoders, a robot's reply to ENCODER.

use crate::wire::{packet, record, record_of};
use crate::{Error, Packet};

/// Kind of the packet.
pub(crate) const KIND: u8 = 0x90;

record! {
    /// Counts of both encoders since the session was opened; they wrap.
    #[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
    Encoders {
        /// Left wheel.
        left: i32,
        /// Right wheel.
        right: i32,
    }
}

impl Encoders {
    /// Encodes the counts as a packet.
    #[must_use]
    pub fn to_packet(&self) -> Packet {
        packet(KIND, self).expect("nine bytes are a payload")
    }

    /// Decodes a packet.
    ///
    /// # Errors
    /// If it is of another kind, or too short.
    pub fn from_packet(packet: &Packet) -> Result<Self, Error> {
        record_of("packet of encoders", KIND, packet)
    }
}
