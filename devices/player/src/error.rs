//! The errors of messages. Bytes of a stream cannot be found again after one of them, so each ends the
//! connection.

use crate::Device;

/// Why bytes are not a message of a Player server.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Error {
    /// The first bytes are not those of a Player server.
    #[error("it is not a Player server: its first bytes are `{start}`")]
    Greeting {
        /// The bytes as text.
        start: String,
    },
    /// A server of another version.
    #[error("it is Player {version}, and only version 3 is supported")]
    Version {
        /// What it reports.
        version: String,
    },
    /// A header with an impossible field.
    #[error("it sent {what} {value}, which no Player server sends")]
    Header {
        /// The field.
        what: &'static str,
        /// Its value.
        value: u32,
    },
    /// A body that ends before its fields do.
    #[error("a message of {device} ends within its {what}")]
    Short {
        /// The sender.
        device: Device,
        /// The field.
        what: &'static str,
    },
    /// Two fields that must be equal and are not.
    #[error("a message of {device} states {first} and then {second} {what}")]
    Count {
        /// The sender.
        device: Device,
        /// The elements that are counted.
        what: &'static str,
        /// The first count.
        first: u32,
        /// The second count.
        second: u32,
    },
}
