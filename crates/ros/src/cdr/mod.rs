//! Values as ROS 2 puts them on the wire and into recordings: plain CDR, little endian, with its encapsulation header. What
//! the bytes of a value are is said by its description; no Rust type is needed.
//!
//! Form: OMG Common Data Representation as DDS-RTPS 2.5, chapter 10, uses it: every number on a multiple of its size from the end
//! of the header, a sequence behind the number of its elements, a text behind the number of its bytes with a NUL at its end.

mod decode;
mod encode;

pub use decode::{decode, decode_into};
pub use encode::encode;

/// CDR, little endian, no options.
const ENCAPSULATION: [u8; 4] = [0, 1, 0, 0];

/// Why a message is no value of a type.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Error {
    /// Another encoding, or big endian.
    #[error("the message begins with {0:02x?}; expected 00 01, plain CDR in little endian")]
    Encapsulation(Vec<u8>),
    /// It ends too soon.
    #[error("the message ends within `{0}`; it was cut, or is of another type")]
    Short(String),
    /// It goes on after the last field.
    #[error("the message has {0} bytes too many; it is of another type")]
    Long(usize),
    /// More elements than there is room for.
    #[error("`{field}` has {got} elements, and room for {capacity}")]
    Capacity {
        /// The field.
        field: String,
        /// Its room.
        capacity: usize,
        /// What the message has.
        got: usize,
    },
    /// A text that is none.
    #[error("`{0}` is no UTF-8 text with a NUL at its end")]
    Text(String),
}

#[cfg(test)]
mod tests;
