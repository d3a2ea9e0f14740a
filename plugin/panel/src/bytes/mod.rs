//! Lists and gestures as bytes: CBOR, which describes itself and is supported by every language.

mod bounded;

use serde::Serialize;
use serde::de::DeserializeOwned;

use crate::Broken;
use crate::limits::MOST_ENCODED;
pub(crate) use bounded::{cells, items, list, points};

/// The maximum depth of nesting in the input.
const MAX_DEPTH: usize = 48;

/// Encodes a list or gesture.
///
/// # Panics
/// Never for types of this crate.
#[must_use]
pub fn encode<T: Serialize>(value: &T) -> Vec<u8> {
    let mut bytes = Vec::new();
    ciborium::into_writer(value, &mut bytes).expect("writing to a vector cannot fail");
    bytes
}

/// Decodes the output of [`encode`]. A list must be checked before it is shown ([`crate::check`]).
///
/// # Errors
/// [`Broken::Encoded`], [`Broken::Bytes`]. For a list also [`Broken::Items`] and [`Broken::Points`], as soon
/// as there are too many, so a few bytes cannot request much memory.
pub fn decode<T: DeserializeOwned>(bytes: &[u8]) -> Result<T, Broken> {
    if bytes.len() > MOST_ENCODED {
        return Err(Broken::Encoded(bytes.len()));
    }
    ciborium::de::from_reader_with_recursion_limit(bytes, MAX_DEPTH).map_err(|error| match error {
        ciborium::de::Error::Semantic(_, message) => bounded::broken(message),
        error => Broken::Bytes(error.to_string()),
    })
}

/// Encodes pixels as one byte string, not as a list of numbers.
pub(crate) mod raw {
    use std::fmt;

    use serde::de::{SeqAccess, Visitor};
    use serde::{Deserializer, Serializer};

    pub(crate) fn serialize<S: Serializer>(bytes: &[u8], serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_bytes(bytes)
    }

    pub(crate) fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Vec<u8>, D::Error> {
        struct Bytes;
        impl<'de> Visitor<'de> for Bytes {
            type Value = Vec<u8>;
            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("bytes")
            }
            fn visit_bytes<E>(self, bytes: &[u8]) -> Result<Self::Value, E> {
                Ok(bytes.to_vec())
            }
            fn visit_byte_buf<E>(self, bytes: Vec<u8>) -> Result<Self::Value, E> {
                Ok(bytes)
            }
            // JSON has no byte strings.
            fn visit_seq<A: SeqAccess<'de>>(self, mut seq: A) -> Result<Self::Value, A::Error> {
                let mut bytes = Vec::new();
                while let Some(byte) = seq.next_element()? {
                    bytes.push(byte);
                }
                Ok(bytes)
            }
        }
        deserializer.deserialize_byte_buf(Bytes)
    }
}
