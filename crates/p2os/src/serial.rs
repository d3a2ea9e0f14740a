//! Bytes that a device at one of the robot's auxiliary serial ports said. What they mean is the device's
//! affair.

use crate::{Error, Packet};

/// An auxiliary serial port.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AuxPort {
    /// The first: TTY2 writes to it, GETAUX reads.
    One,
    /// The second.
    Two,
}

/// What came in at an auxiliary serial port.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SerialAux {
    /// Where.
    pub port: AuxPort,
    /// What.
    pub bytes: Vec<u8>,
}

impl SerialAux {
    /// The packet that says it.
    ///
    /// # Errors
    /// If it is more than fits.
    pub fn to_packet(&self) -> Result<Packet, Error> {
        let mut payload = vec![match self.port {
            AuxPort::One => 0xB0,
            AuxPort::Two => 0xB8,
        }];
        payload.extend(&self.bytes);
        Packet::new(&payload)
    }

    /// Understands a packet.
    ///
    /// # Errors
    /// If it is of another kind.
    pub fn from_packet(packet: &Packet) -> Result<Self, Error> {
        let port = match packet.id() {
            0xB0 => AuxPort::One,
            0xB8 => AuxPort::Two,
            have => {
                let what = "packet of an auxiliary port";
                return Err(Error::Kind { what, have });
            }
        };
        let bytes = packet.data().to_vec();
        Ok(Self { port, bytes })
    }
}
