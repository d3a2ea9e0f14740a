//! The errors of packets. None of them ends a connection: the receiver drops the packet and continues.

/// Why a packet could not be encoded or decoded.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Error {
    /// A payload whose length is invalid.
    #[error("a payload of {have} bytes: expected 1 to {}", crate::packet::MAX_PAYLOAD)]
    Payload {
        /// Its length.
        have: usize,
    },
    /// A packet of a kind other than expected.
    #[error("a packet of kind {have:#04x} is not a {what}")]
    Kind {
        /// The expected kind.
        what: &'static str,
        /// Its first byte.
        have: u8,
    },
    /// A packet that ends before its fields do.
    #[error("the packet ends within its {what}: drop it and wait for the next one")]
    Short {
        /// The part that is too short.
        what: &'static str,
    },
    /// A field that contradicts the others.
    #[error("the packet's {what} contradicts the rest: drop it and wait for the next one")]
    Contradiction {
        /// The field.
        what: &'static str,
    },
}
