//! Bytes from a device at one of the robot's auxiliary serial ports. The device's own module
//! interprets them.

use crate::{Error, Packet};

/// An auxiliary serial port.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AuxPort {
    /// The first: TTY2 writes to it, GETAUX reads.
    One,
    /// The second.
    Two,
}

/// Bytes that arrived at an auxiliary serial port.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SerialAux {
    /// The port.
    pub port: AuxPort,
    /// The bytes.
    pub bytes: Vec<u8>,
}

impl SerialAux {
    /// Encodes the bytes as a packet.
    ///
    /// # Errors
    /// If there are too many bytes for a packet.
    pub fn to_packet(&self) -> Result<Packet, Error> {
        let mut payload = vec![match self.port {
            AuxPort::One => 0xB0,
            AuxPort::Two => 0xB8,
        }];
        payload.extend(&self.bytes);
        Packet::new(&payload)
    }

    /// Decodes a packet.
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
