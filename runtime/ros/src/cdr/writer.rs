//! Writes the parts of a message one after the other.

use super::CDR_LITTLE_ENDIAN;

/// A message that is being written.
pub struct Writer<'a> {
    message: &'a mut Vec<u8>,
    /// Bytes of the message that are elsewhere.
    elsewhere: usize,
}

impl<'a> Writer<'a> {
    /// Begins a message, which replaces the contents of `message`.
    pub fn new(message: &'a mut Vec<u8>) -> Self {
        message.clear();
        message.extend_from_slice(&CDR_LITTLE_ENDIAN);
        Self {
            message,
            elsewhere: 0,
        }
    }

    /// Returns the number of bytes written.
    pub(super) fn written(&self) -> usize {
        self.message.len()
    }

    /// Continues after as many bytes that are elsewhere.
    pub(super) fn leave_out(&mut self, bytes: usize) {
        self.elsewhere += bytes;
    }

    /// Advances to the next multiple of `alignment`.
    pub fn align(&mut self, alignment: usize) {
        let body = self.message.len() + self.elsewhere - CDR_LITTLE_ENDIAN.len();
        let gap = body.next_multiple_of(alignment) - body;
        self.message.resize(self.message.len() + gap, 0);
    }

    /// Writes bytes without alignment.
    pub fn bytes(&mut self, bytes: &[u8]) {
        self.message.extend_from_slice(bytes);
    }

    /// Writes the bytes of a number, little endian, at a multiple of its size.
    pub fn number<const BYTES: usize>(&mut self, bytes: [u8; BYTES]) {
        self.align(BYTES);
        self.bytes(&bytes);
    }

    /// Writes the number of elements of a sequence.
    pub fn length(&mut self, length: usize) {
        // No message has as many elements as 32 bits count.
        self.number((length as u32).to_le_bytes());
    }

    /// Writes a text with the NUL at its end. Each byte that is not UTF-8 becomes `?`, so the number of bytes is
    /// that of the original.
    pub fn text(&mut self, text: &[u8]) {
        self.length(text.len() + 1);
        for chunk in text.utf8_chunks() {
            self.bytes(chunk.valid().as_bytes());
            self.message.extend(chunk.invalid().iter().map(|_| b'?'));
        }
        self.message.push(0);
    }
}
