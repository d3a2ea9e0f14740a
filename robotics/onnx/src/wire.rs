//! The wire format of protocol buffers (<https://protobuf.dev/programming-guides/encoding>): the fields of one message.
//! It knows no message.

/// A field's value.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Wire<'a> {
    /// A number of variable length.
    Varint(u64),
    /// Four bytes.
    Fixed32(u32),
    /// Eight bytes, which nothing that is read has.
    Fixed64,
    /// A text, a message, or packed numbers.
    Bytes(&'a [u8]),
}

/// The bytes are no message.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Malformed;

impl From<Malformed> for crate::OnnxError {
    fn from(_: Malformed) -> Self {
        Self::Model("the file is damaged or no ONNX file: its fields do not fit together".to_owned())
    }
}

/// The fields of a message in their order.
pub(crate) struct Fields<'a>(pub(crate) &'a [u8]);

impl<'a> Fields<'a> {
    fn take(&mut self, count: usize) -> Result<&'a [u8], Malformed> {
        let (taken, rest) = self.0.split_at_checked(count).ok_or(Malformed)?;
        self.0 = rest;
        Ok(taken)
    }

    fn varint(&mut self) -> Result<u64, Malformed> {
        let mut value = 0;
        for shift in (0..64).step_by(7) {
            let byte = self.take(1)?[0];
            value |= u64::from(byte & 0x7f) << shift;
            if byte & 0x80 == 0 {
                return Ok(value);
            }
        }
        Err(Malformed)
    }

    fn field(&mut self) -> Result<(u64, Wire<'a>), Malformed> {
        let key = self.varint()?;
        let value = match key & 7 {
            0 => Wire::Varint(self.varint()?),
            1 => self.take(8).map(|_| Wire::Fixed64)?,
            2 => {
                let length = self.varint()?;
                Wire::Bytes(self.take(usize::try_from(length).map_err(|_| Malformed)?)?)
            }
            5 => Wire::Fixed32(u32::from_le_bytes(*self.take(4)?.first_chunk().ok_or(Malformed)?)),
            _ => return Err(Malformed),
        };
        Ok((key >> 3, value))
    }
}

impl<'a> Iterator for Fields<'a> {
    type Item = Result<(u64, Wire<'a>), Malformed>;

    fn next(&mut self) -> Option<Self::Item> {
        if self.0.is_empty() {
            return None;
        }
        let field = self.field();
        if field.is_err() {
            self.0 = &[];
        }
        Some(field)
    }
}

impl<'a> Wire<'a> {
    pub(crate) fn bytes(self) -> Result<&'a [u8], Malformed> {
        match self {
            Self::Bytes(bytes) => Ok(bytes),
            Self::Varint(_) | Self::Fixed32(_) | Self::Fixed64 => Err(Malformed),
        }
    }

    pub(crate) fn text(self) -> Result<String, Malformed> {
        String::from_utf8(self.bytes()?.to_vec()).map_err(|_| Malformed)
    }

    pub(crate) fn integer(self) -> Result<i64, Malformed> {
        match self {
            Self::Varint(value) => Ok(value.cast_signed()),
            Self::Fixed32(_) | Self::Fixed64 | Self::Bytes(_) => Err(Malformed),
        }
    }

    pub(crate) fn float(self) -> Result<f32, Malformed> {
        match self {
            Self::Fixed32(bits) => Ok(f32::from_bits(bits)),
            Self::Varint(_) | Self::Fixed64 | Self::Bytes(_) => Err(Malformed),
        }
    }

    /// Appends whole numbers, packed or one.
    pub(crate) fn integers(self, to: &mut Vec<i64>) -> Result<(), Malformed> {
        let Self::Bytes(packed) = self else {
            to.push(self.integer()?);
            return Ok(());
        };
        let mut packed = Fields(packed);
        while !packed.0.is_empty() {
            to.push(packed.varint()?.cast_signed());
        }
        Ok(())
    }

    /// Appends numbers, packed or one.
    pub(crate) fn floats(self, to: &mut Vec<f32>) -> Result<(), Malformed> {
        let Self::Bytes(packed) = self else {
            to.push(self.float()?);
            return Ok(());
        };
        let (numbers, []) = packed.as_chunks::<4>() else {
            return Err(Malformed);
        };
        to.extend(numbers.iter().map(|bytes| f32::from_le_bytes(*bytes)));
        Ok(())
    }
}
