//! A value received over the link, with its attachment.

use std::ops::Deref;
use std::sync::Arc;

use jde_abi::describe::Type;
use jde_board::Nanos;
use jde_board::value::{self, Value};
use jde_ros::cdr;

use crate::attachment::Tag;

/// A value of a variable, or the fact that there is none.
#[derive(Clone, Debug)]
pub struct Sample {
    /// Its type.
    pub value_type: Arc<Type>,
    /// The bytes, laid out as the type defines; none if no value was written yet or it was retracted.
    pub bytes: Option<ValueBytes>,
    /// Counts the values of the variable from 1; 0 is the initial value, or none.
    pub sequence: u64,
    /// When the value was measured or written, ns since the application's start.
    pub time: Nanos,
    /// The age of the value when it was sent, ns of the application.
    pub age: Nanos,
    /// When a command expires, ns since the application's start; the greatest number for values that do not
    /// expire.
    pub valid_until: Nanos,
    /// The writer; empty if there is none.
    pub writer: String,
}

/// The bytes of a value. Clones share them.
#[derive(Clone, Debug, Default)]
pub struct ValueBytes(Arc<Vec<u8>>);

/// Memory for values, which is used again once nobody has its value. There may be one that somebody keeps and the next one.
#[derive(Default)]
pub(crate) struct ValueMemory([ValueBytes; 2]);

impl Sample {
    /// Reads a message in pieces.
    ///
    /// # Errors
    /// If it is no value of the type.
    pub(crate) fn read(
        value_type: &Arc<Type>,
        pieces: &[&[u8]],
        attachment: Option<&[u8]>,
        memory: &mut ValueMemory,
    ) -> Result<Self, String> {
        let tag = attachment
            .and_then(Tag::read)
            .ok_or("a value without its attachment")?;
        let bytes = if tag.retracted {
            None
        } else {
            Some(
                memory
                    .decode(value_type, pieces)
                    .map_err(|error| error.to_string())?,
            )
        };
        Ok(Self {
            value_type: Arc::clone(value_type),
            bytes,
            sequence: tag.sequence,
            time: tag.time,
            age: tag.age,
            valid_until: tag.valid_until,
            writer: tag.writer,
        })
    }

    /// The value as fields by name.
    #[must_use]
    pub fn value(&self) -> Option<Value> {
        let bytes = self.bytes.as_ref()?;
        Some(value::decode(&self.value_type, bytes))
    }
}

impl ValueMemory {
    fn decode(&mut self, value_type: &Type, pieces: &[&[u8]]) -> Result<ValueBytes, cdr::Error> {
        let free = self.0.iter().position(|bytes| Arc::strong_count(&bytes.0) == 1);
        let free = free.unwrap_or_else(|| {
            self.0[0] = ValueBytes::default();
            0
        });
        let bytes = Arc::make_mut(&mut self.0[free].0);
        bytes.resize(value_type.bytes, 0);
        cdr::decode_pieces(value_type, pieces, bytes)?;
        Ok(self.0[free].clone())
    }
}

impl From<Vec<u8>> for ValueBytes {
    fn from(bytes: Vec<u8>) -> Self {
        Self(Arc::new(bytes))
    }
}

impl Deref for ValueBytes {
    type Target = [u8];

    fn deref(&self) -> &[u8] {
        &self.0
    }
}

#[cfg(test)]
mod tests {
    use jde_types::{Text, Value as _};

    use super::*;

    #[test]
    fn values_that_are_kept_stay_as_they_are_and_memory_is_used_again() {
        let value_type = Text::<60>::describe();
        let mut memory = ValueMemory::default();
        let mut decode = |text: &str| {
            let mut message = Vec::new();
            cdr::encode(&value_type, Text::<60>::new(text).as_bytes(), &mut message);
            memory.decode(&value_type, &[&message]).unwrap()
        };
        let text = |bytes: &ValueBytes| Text::<60>::from_bytes(bytes).unwrap();
        let first = decode("a long first text");
        let second = decode("two");
        let third = decode("three");
        let expected = [("a long first text", &first), ("two", &second), ("three", &third)];
        for (expected, bytes) in expected {
            assert_eq!(text(bytes).as_str(), expected);
        }
        let place = second.as_ptr();
        drop(second);
        let fourth = decode("4");
        assert_eq!((text(&fourth).as_str(), fourth.as_ptr()), ("4", place));
        assert_eq!(text(&first).as_str(), "a long first text");
    }
}
