//! What the wheels' encoders have counted, which a robot tells when asked by ENCODER.

use crate::wire::{packet, record, record_of};
use crate::{Error, Packet};

/// Kind of the packet.
pub(crate) const KIND: u8 = 0x90;

record! {
    /// Counts of both encoders since the robot was opened; they wrap.
    #[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
    Encoders {
        /// Of the left wheel.
        left: i32,
        /// Of the right wheel.
        right: i32,
    }
}

impl Encoders {
    /// The packet that says it.
    #[must_use]
    pub fn to_packet(&self) -> Packet {
        packet(KIND, self).expect("nine bytes are a payload")
    }

    /// Understands a packet.
    ///
    /// # Errors
    /// If it is of another kind, or ends too early.
    pub fn from_packet(packet: &Packet) -> Result<Self, Error> {
        record_of("packet of encoders", KIND, packet)
    }
}
