//! One packet of the protocol: `FA FB`, a count, a payload, a checksum. What a payload means is said
//! elsewhere.

use crate::Error;

/// Most bytes a payload has: the count, which covers the checksum too, goes up to 200.
pub const MAX_PAYLOAD: usize = 198;

/// What every packet begins with.
pub(crate) const HEADER: [u8; 2] = [0xFA, 0xFB];

/// Most bytes a packet has on the wire.
pub(crate) const MAX_WIRE: usize = 3 + MAX_PAYLOAD + 2;

/// A payload of 1 to [`MAX_PAYLOAD`] bytes; its first byte says of which kind it is.
#[derive(Clone, Copy)]
pub struct Packet {
    length: u8,
    bytes: [u8; MAX_PAYLOAD],
}

impl Packet {
    /// Wraps a payload.
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

    /// The first byte of the payload: the number of a command, or the kind of an answer.
    #[must_use]
    pub fn id(&self) -> u8 {
        self.bytes[0]
    }

    /// The payload, the id with it.
    #[must_use]
    pub fn payload(&self) -> &[u8] {
        &self.bytes[..usize::from(self.length)]
    }

    /// What follows the id.
    #[must_use]
    pub fn data(&self) -> &[u8] {
        &self.payload()[1..]
    }

    /// The packet as it goes over the wire.
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

/// The checksum of a payload: its big-endian words summed, an odd last byte then XORed in.
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
