//! What all messages of a recording may take, by the bytes that they are read from. Packed zeros of hours are no recording:
//! a small file of them would take minutes and tell nothing.

/// Messages have at most this many times the bytes that they are packed in, and all together so many more.
const MAX_EXPANSION: u64 = 1024;
const MORE_BYTES: u64 = 256 << 20;
/// The bytes in which a message is packed at least, since messages differ in time and number; and how many have less.
const PACKED_MESSAGE: u64 = 2;
const MORE_MESSAGES: u64 = 1 << 20;

/// What may still be read of a recording.
pub(super) struct Allowance {
    bytes: u64,
    messages: u64,
}

impl Default for Allowance {
    fn default() -> Self {
        Self {
            bytes: MORE_BYTES,
            messages: MORE_MESSAGES,
        }
    }
}

impl Allowance {
    /// Takes bytes and messages that were packed in `packed` bytes.
    ///
    /// # Errors
    /// These and those before them are too many.
    pub(super) fn take(&mut self, packed: u64, bytes: u64, messages: u64) -> Result<(), String> {
        let allowed = packed.saturating_mul(MAX_EXPANSION).saturating_add(self.bytes);
        self.bytes = allowed
            .checked_sub(bytes)
            .ok_or_else(|| format!("its messages have more than {MAX_EXPANSION} times its bytes"))?;
        let allowed = (packed / PACKED_MESSAGE).saturating_add(self.messages);
        self.messages = allowed
            .checked_sub(messages)
            .ok_or_else(|| format!("it has more than a message for each {PACKED_MESSAGE} of its bytes"))?;
        Ok(())
    }
}
