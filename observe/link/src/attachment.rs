//! The attachments of values and panels on the wire: time, sequence and writer. Little endian with fixed
//! offsets; the writer's name is last.

use jde_board::Nanos;
use jde_records::check::MAX_TIME;

/// Bytes before the writer's name.
const HEAD_BYTES: usize = 33;
/// Bytes of a panel's attachment.
const PANEL_BYTES: usize = 25;
/// Longest name that is sent, bytes.
const MAX_NAME_BYTES: usize = 255;

const RETRACTED_FLAG: u8 = 1;

/// The attachment of a value.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Tag {
    /// Counts the values of the variable from 1; 0 is the initial value, or none.
    pub(crate) sequence: u64,
    /// When the value was measured or written, ns since the application's start.
    pub(crate) time: Nanos,
    /// The age of the value when it was sent, ns of the application.
    pub(crate) age: Nanos,
    /// When a command expires, ns since the application's start; the greatest number for values that do not
    /// expire.
    pub(crate) valid_until: Nanos,
    /// There is no value: it was retracted, or none was written yet.
    pub(crate) retracted: bool,
    /// The writer; empty if there is none.
    pub(crate) writer: String,
}

/// The attachment of a panel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct PanelTag {
    /// Counts the drawings of the panel from 1.
    pub(crate) sequence: u64,
    /// When the panel was drawn, ns since the application's start.
    pub(crate) time: Nanos,
    /// The age of the drawing when it was sent, ns of the application.
    pub(crate) age: Nanos,
    /// There is no list; the message is the reason.
    pub(crate) is_error: bool,
}

impl PanelTag {
    pub(crate) fn bytes(&self) -> [u8; PANEL_BYTES] {
        let mut bytes = [0; PANEL_BYTES];
        for (index, number) in [self.sequence, self.time, self.age].into_iter().enumerate() {
            bytes[index * 8..][..8].copy_from_slice(&number.to_le_bytes());
        }
        bytes[PANEL_BYTES - 1] = u8::from(self.is_error);
        bytes
    }

    pub(crate) fn read(bytes: &[u8]) -> Option<Self> {
        let bytes: &[u8; PANEL_BYTES] = bytes.first_chunk()?;
        let number = |index: usize| bytes[index * 8..][..8].try_into().ok().map(u64::from_le_bytes);
        let (time, age) = (number(1)?, number(2)?);
        (time.max(age) <= MAX_TIME).then_some(Self {
            sequence: number(0)?,
            time,
            age,
            is_error: bytes[PANEL_BYTES - 1] & 1 != 0,
        })
    }
}

impl Tag {
    pub(crate) fn bytes(&self) -> Vec<u8> {
        let mut end = self.writer.len().min(MAX_NAME_BYTES);
        while !self.writer.is_char_boundary(end) {
            end -= 1;
        }
        let mut bytes = Vec::with_capacity(HEAD_BYTES + end);
        for number in [self.sequence, self.time, self.age, self.valid_until] {
            bytes.extend_from_slice(&number.to_le_bytes());
        }
        bytes.push(if self.retracted { RETRACTED_FLAG } else { 0 });
        bytes.extend_from_slice(&self.writer.as_bytes()[..end]);
        bytes
    }

    pub(crate) fn read(bytes: &[u8]) -> Option<Self> {
        let (head, name) = bytes.split_at_checked(HEAD_BYTES)?;
        let number = |index: usize| head[index * 8..][..8].try_into().ok().map(u64::from_le_bytes);
        if name.len() > MAX_NAME_BYTES {
            return None;
        }
        let (time, age) = (number(1)?, number(2)?);
        (time.max(age) <= MAX_TIME).then_some(Self {
            sequence: number(0)?,
            time,
            age,
            valid_until: number(3)?,
            retracted: head[HEAD_BYTES - 1] & RETRACTED_FLAG != 0,
            writer: std::str::from_utf8(name).ok()?.to_owned(),
        })
    }
}

/// Reads the sequence number of an event.
pub(crate) fn number(bytes: &[u8]) -> Option<u64> {
    bytes.try_into().ok().map(u64::from_le_bytes)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn a_tag_is_read_as_it_was_written(
            numbers in any::<[u64; 4]>(), retracted in any::<bool>(), writer in "\\PC{0,60}",
        ) {
            let [sequence, time, age, valid_until] = numbers;
            let (time, age) = (time % MAX_TIME, age % MAX_TIME);
            let tag = Tag { sequence, time, age, valid_until, retracted, writer };
            prop_assert_eq!(Tag::read(&tag.bytes()), Some(tag));
        }

        #[test]
        fn reading_attachments_survives_any_bytes(bytes in proptest::collection::vec(any::<u8>(), 0..400)) {
            if let Some(tag) = Tag::read(&bytes) {
                prop_assert!(bytes.len() >= HEAD_BYTES && tag.writer.len() <= MAX_NAME_BYTES);
            }
            prop_assert_eq!(number(&bytes).is_some(), bytes.len() == 8);
        }

        #[test]
        fn a_panel_tag_is_read_as_it_was_written(numbers in any::<[u64; 3]>(), is_error in any::<bool>(), more in any::<Vec<u8>>()) {
            let [sequence, time, age] = numbers;
            let (time, age) = (time % MAX_TIME, age % MAX_TIME);
            let tag = PanelTag { sequence, time, age, is_error };
            let mut bytes = tag.bytes().to_vec();
            bytes.extend(more);
            prop_assert_eq!(PanelTag::read(&bytes), Some(tag), "newer peers may append fields");
            prop_assert_eq!(PanelTag::read(&bytes[..PANEL_BYTES - 1]), None);
        }

        #[test]
        fn a_long_name_is_cut_between_characters(writer in "\\PC{200,400}") {
            let tag = Tag {
                sequence: 1, time: 2, age: 3, valid_until: 4, retracted: false, writer: writer.clone(),
            };
            let read = Tag::read(&tag.bytes()).unwrap();
            prop_assert!(writer.starts_with(&read.writer));
        }
    }
}
