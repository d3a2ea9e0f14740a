//! A value received over the link, with its attachment.

use std::sync::Arc;

use jde_abi::describe::Type;
use jde_board::Nanos;
use jde_board::value::{self, Value};

use crate::attachment::Tag;

/// A value of a variable, or the fact that there is none.
#[derive(Clone, Debug)]
pub struct Sample {
    /// Its type.
    pub value_type: Arc<Type>,
    /// The bytes, laid out as the type defines; none if no value was written yet or it was retracted.
    pub bytes: Option<Vec<u8>>,
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

impl Sample {
    pub(crate) fn read(
        value_type: &Arc<Type>,
        pieces: &[&[u8]],
        attachment: Option<&[u8]>,
    ) -> Result<Self, String> {
        let tag = attachment
            .and_then(Tag::read)
            .ok_or("a value without its attachment")?;
        let bytes = if tag.retracted {
            None
        } else {
            let mut bytes = vec![0; value_type.bytes];
            jde_ros::cdr::decode_pieces(value_type, pieces, &mut bytes).map_err(|error| error.to_string())?;
            Some(bytes)
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
