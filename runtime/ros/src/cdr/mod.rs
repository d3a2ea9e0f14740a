//! Values as ROS 2 transmits and records them: plain CDR, little endian, with its encapsulation header. A
//! description gives the meaning of the bytes; no Rust type is needed. [`Writer`] and [`Reader`] are for messages
//! that are no values, because their texts and sequences have no bounds.
//!
//! Form: OMG Common Data Representation as in DDS-RTPS 2.5, chapter 10. Every number is at a multiple of its
//! size from the end of the header. A sequence follows the number of its elements. A text follows the number
//! of its bytes, and ends with a NUL, which is counted.

mod decode;
mod encode;
mod extent;
mod pieces;
mod reader;
mod writer;

pub use decode::{decode, decode_cutting, decode_into, decode_pieces};
pub use encode::{Uncopied, encode, encode_in_place};
pub use extent::Extent;
pub use pieces::OnCut;
pub use reader::Reader;
pub use writer::Writer;

/// CDR, little endian, no options.
const CDR_LITTLE_ENDIAN: [u8; 4] = [0, 1, 0, 0];

/// Why a message is not a value of a type.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Error {
    /// The encoding is another one, or big endian.
    #[error("the message begins with {0:02x?}; expected 00 01, plain CDR in little endian")]
    Encapsulation(Vec<u8>),
    /// The message is too short.
    #[error("the message ends within `{0}`; it was cut, or is of another type")]
    Truncated(String),
    /// The message continues after the last field.
    #[error("the message has {0} bytes too many; it is of another type")]
    Long(usize),
    /// A sequence or text is longer than its capacity.
    #[error("`{field}` has {got} elements, and room for {capacity}")]
    Capacity {
        /// The field.
        field: String,
        /// Its capacity.
        capacity: usize,
        /// The length in the message.
        got: usize,
    },
    /// A text is not valid.
    #[error("`{0}` is no UTF-8 text with a NUL at its end")]
    Text(String),
    /// A text is none of the names that the field can have.
    #[error("`{field}` is `{name}`, which is none of its names")]
    Name {
        /// The field.
        field: String,
        /// The text.
        name: String,
    },
}

impl Error {
    /// Returns the error of a text in a list as that of the list.
    fn in_list(self, list: &str) -> Self {
        let field = list.to_owned();
        match self {
            Self::Truncated(_) => Self::Truncated(field),
            Self::Text(_) => Self::Text(field),
            Self::Capacity { capacity, got, .. } => Self::Capacity { field, capacity, got },
            other => other,
        }
    }

    /// Checks the first four bytes of a message, or as many as it has.
    fn check_encapsulation(head: &[u8]) -> Result<(), Self> {
        // The second half contains options, which do not affect the body.
        if head.len() < CDR_LITTLE_ENDIAN.len() || head[..2] != CDR_LITTLE_ENDIAN[..2] {
            return Err(Self::Encapsulation(head.to_vec()));
        }
        Ok(())
    }

    /// Checks the number of bytes after the last field.
    fn check_surplus(surplus: usize) -> Result<(), Self> {
        // Some writers pad the body to a multiple of four bytes.
        if surplus >= 4 {
            return Err(Self::Long(surplus));
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests;
