//! What can be wrong with a packet. Nothing here ends a connection: who receives drops the packet and goes
//! on.

/// Why a packet was not made or not understood.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Error {
    /// A payload of a length that no packet has.
    #[error("a payload of {have} bytes: expected 1 to {}", crate::packet::MAX_PAYLOAD)]
    Payload {
        /// Its length.
        have: usize,
    },
    /// A packet of another kind than was asked for.
    #[error("a packet of kind {have:#04x} is no {what}")]
    Kind {
        /// What was expected.
        what: &'static str,
        /// Its first byte.
        have: u8,
    },
    /// A packet that ends before its fields do.
    #[error("the packet ends within its {what}: drop it, the next one comes")]
    Short {
        /// What was being read.
        what: &'static str,
    },
    /// A field that contradicts the others.
    #[error("the packet's {what} contradicts the rest: drop it, the next one comes")]
    Contradiction {
        /// The field.
        what: &'static str,
    },
}
