//! Reads the parts of a message one after the other.

use super::{CDR_LITTLE_ENDIAN, Error};

/// The rest of a message. Each function names the field that it reads, for the error message.
pub struct Reader<'a> {
    /// The bytes after the header.
    body: &'a [u8],
    position: usize,
}

impl<'a> Reader<'a> {
    /// Begins with the first field of a message.
    ///
    /// # Errors
    /// [`Error::Encapsulation`].
    pub fn new(message: &'a [u8]) -> Result<Self, Error> {
        let (head, body) = message.split_at(message.len().min(CDR_LITTLE_ENDIAN.len()));
        Error::check_encapsulation(head)?;
        Ok(Self { body, position: 0 })
    }

    /// Returns `count` bytes from the next multiple of `align` on.
    ///
    /// # Errors
    /// [`Error::Truncated`].
    pub fn take(&mut self, align: usize, count: usize, field: &str) -> Result<&'a [u8], Error> {
        let start = self.position.next_multiple_of(align);
        let bytes = start
            .checked_add(count)
            .and_then(|end| self.body.get(start..end))
            .ok_or_else(|| Error::Truncated(field.to_owned()))?;
        self.position = start + count;
        Ok(bytes)
    }

    /// Returns the bytes of a number, which is at a multiple of its size.
    ///
    /// # Errors
    /// [`Error::Truncated`].
    pub fn number<const BYTES: usize>(&mut self, field: &str) -> Result<[u8; BYTES], Error> {
        let mut bytes = [0; BYTES];
        bytes.copy_from_slice(self.take(BYTES, BYTES, field)?);
        Ok(bytes)
    }

    /// Returns the number of elements of a sequence, which may exceed the rest of the message.
    ///
    /// # Errors
    /// [`Error::Truncated`].
    pub fn length(&mut self, field: &str) -> Result<usize, Error> {
        Ok(u32::from_le_bytes(self.number(field)?) as usize)
    }

    /// Returns a text without its NUL.
    ///
    /// # Errors
    /// [`Error::Truncated`], [`Error::Text`].
    pub fn text(&mut self, field: &str) -> Result<&'a str, Error> {
        let count = self.length(field)?;
        let bytes = self.take(1, count, field)?;
        let text = bytes.strip_suffix(&[0]);
        text.and_then(|text| std::str::from_utf8(text).ok())
            .ok_or_else(|| Error::Text(field.to_owned()))
    }

    /// Whether all of the message was read.
    #[must_use]
    pub fn is_at_end(&self) -> bool {
        Error::check_surplus(self.body.len() - self.position).is_ok()
    }

    /// Ends after the last field.
    ///
    /// # Errors
    /// [`Error::Long`].
    pub fn finish(self) -> Result<(), Error> {
        Error::check_surplus(self.body.len() - self.position)
    }
}
