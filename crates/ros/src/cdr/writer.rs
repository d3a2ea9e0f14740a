//! Writes the parts of a message one after the other.

use super::ENCAPSULATION;

/// A message that is being written.
pub struct Writer<'a>(&'a mut Vec<u8>);

impl<'a> Writer<'a> {
    /// Begins a message, which replaces the contents of `message`.
    pub fn new(message: &'a mut Vec<u8>) -> Self {
        message.clear();
        message.extend_from_slice(&ENCAPSULATION);
        Self(message)
    }

    /// Advances to the next multiple of `alignment`.
    pub fn align(&mut self, alignment: usize) {
        let body = self.0.len() - ENCAPSULATION.len();
        self.0
            .resize(ENCAPSULATION.len() + body.next_multiple_of(alignment), 0);
    }

    /// Writes bytes without alignment.
    pub fn bytes(&mut self, bytes: &[u8]) {
        self.0.extend_from_slice(bytes);
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
            self.0.extend(chunk.invalid().iter().map(|_| b'?'));
        }
        self.0.push(0);
    }
}
