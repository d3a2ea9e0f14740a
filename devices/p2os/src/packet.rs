//! One packet of the protocol: `FA FB`, a count, a payload, a checksum. It does not interpret payloads.

use crate::Error;

/// Most bytes in a payload: the count, which includes the checksum, is at most 200.
pub const MAX_PAYLOAD: usize = 198;

/// The first bytes of every packet.
pub(crate) const HEADER: [u8; 2] = [0xFA, 0xFB];

/// Most bytes of a packet on the wire.
pub(crate) const MAX_WIRE: usize = 3 + MAX_PAYLOAD + 2;

/// A payload of 1 to [`MAX_PAYLOAD`] bytes. Its first byte is its kind.
#[derive(Clone, Copy)]
pub struct Packet {
    length: u8,
    bytes: [u8; MAX_PAYLOAD],
}

impl Packet {
    /// Creates a packet from a payload.
    ///
    /// # Errors
    /// If it is empty or longer than [`MAX_PAYLOAD`].
    pub fn new(payload: &[u8]) -> Result<Self, Error> {
        if payload.is_empty() || payload.len() > MAX_PAYLOAD {
            return Err(Error::Payload { have: payload.len() });
        }
        let mut bytes = [0; MAX_PAYLOAD];
        bytes[..payload.len()].copy_from_slice(payload);
        Ok(Self {
            length: payload.len() as u8,
            bytes,
        })
    }

    /// Returns the first byte of the payload: the number of a command, or the kind of a reply.
    #[must_use]
    pub fn id(&self) -> u8 {
        self.bytes[0]
    }

    /// Returns the payload, including the id.
    #[must_use]
    pub fn payload(&self) -> &[u8] {
        &self.bytes[..usize::from(self.length)]
    }

    /// Returns the bytes after the id.
    #[must_use]
    pub fn data(&self) -> &[u8] {
        &self.payload()[1..]
    }

    /// Returns the bytes on the wire.
    #[must_use]
    pub fn to_bytes(&self) -> Vec<u8> {
        let payload = self.payload();
        let mut wire = Vec::with_capacity(payload.len() + 5);
        wire.extend(HEADER);
        wire.push(self.length + 2);
        wire.extend(payload);
        wire.extend(checksum(payload).to_be_bytes());
        wire
    }
}

/// Returns the checksum of a payload: the sum of its big-endian words, XORed with an odd last byte.
#[must_use]
pub fn checksum(payload: &[u8]) -> u16 {
    let (words, rest) = payload.as_chunks::<2>();
    let sum = words
        .iter()
        .fold(0u16, |sum, word| sum.wrapping_add(u16::from_be_bytes(*word)));
    rest.iter().fold(sum, |sum, byte| sum ^ u16::from(*byte))
}

impl PartialEq for Packet {
    fn eq(&self, other: &Self) -> bool {
        self.payload() == other.payload()
    }
}

impl Eq for Packet {}

impl core::fmt::Debug for Packet {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        write!(f, "Packet({:02x?})", self.payload())
    }
}
