//! Reads a variable as messages. A message refers to long lists in the value itself, which therefore does not change as long
//! as the message exists. The memory of everything else is used again.

use std::sync::Arc;

use bytes::Bytes;
use jde_board::{Latched, Nanos, Reader, Variable};
use jde_ros::cdr;
use zenoh::bytes::ZBytes;

use super::subject::Subject;
use crate::attachment::Tag;

/// A reader of one variable.
pub(super) struct ValueReader {
    reader: Arc<Reader>,
    copied: Arc<Vec<u8>>,
}

/// A latched value of a reader that nobody else uses until this is dropped.
struct HeldValue(Arc<Reader>);

/// Bytes that nobody changes until this is dropped.
struct HeldBytes(Arc<Vec<u8>>);

impl ValueReader {
    pub(super) fn new(variable: &Arc<Variable>) -> Self {
        Self {
            reader: Arc::new(variable.reader("link").of_what_is_in_force()),
            copied: Arc::default(),
        }
    }

    /// Returns the newest value with its attachment; `None` if it is the one that was sent: its number, and whether there
    /// was a value.
    pub(super) fn newest(
        &mut self,
        subject: &dyn Subject,
        sent: Option<(u64, bool)>,
    ) -> Option<(Tag, ZBytes)> {
        let newest = self.reader.newest();
        let now = subject.now();
        let variable = self.reader.variable();
        if variable.has_value(now) && sent == Some((newest, true)) {
            return None;
        }
        let (tag, message) = match self.latch(now) {
            Some(Latched { stamp, .. }) => {
                let tag = Tag {
                    sequence: stamp.sequence,
                    time: stamp.time,
                    age: now.saturating_sub(stamp.time),
                    valid_until: stamp.valid_until,
                    retracted: false,
                    writer: subject.writer(stamp.writer),
                };
                (tag, self.message())
            }
            None => {
                let tag = Tag {
                    sequence: newest,
                    time: now,
                    age: 0,
                    valid_until: u64::MAX,
                    retracted: true,
                    writer: String::new(),
                };
                (tag, ZBytes::new())
            }
        };
        (sent != Some((tag.sequence, !tag.retracted))).then_some((tag, message))
    }

    /// Latches the newest value. A message that still exists keeps the reader and its value.
    fn latch(&mut self, now: Nanos) -> Option<Latched<'_>> {
        if Arc::get_mut(&mut self.reader).is_none() {
            self.reader = Arc::new(self.reader.duplicate());
        }
        Arc::get_mut(&mut self.reader)?.latch_newest(now)
    }

    /// Encodes the latched value.
    fn message(&mut self) -> ZBytes {
        if Arc::get_mut(&mut self.copied).is_none() {
            self.copied = Arc::default();
        }
        let copied = Arc::make_mut(&mut self.copied);
        let value = Bytes::from_owner(HeldValue(Arc::clone(&self.reader)));
        let value_type = &self.reader.variable().describe().value_type;
        let uncopied = cdr::encode_in_place(value_type, &value, copied);
        let copied = Bytes::from_owner(HeldBytes(Arc::clone(&self.copied)));
        let mut message = ZBytes::writer();
        let mut from = 0;
        for part in uncopied {
            message.append(copied.slice(from..part.after).into());
            message.append(value.slice_ref(part.numbers).into());
            from = part.after;
        }
        message.append(copied.slice(from..).into());
        message.finish()
    }
}

impl AsRef<[u8]> for HeldValue {
    fn as_ref(&self) -> &[u8] {
        self.0.latched().map_or(&[], |latched| latched.bytes)
    }
}

impl AsRef<[u8]> for HeldBytes {
    fn as_ref(&self) -> &[u8] {
        &self.0
    }
}

#[cfg(test)]
mod tests {
    use jde_board::{Access, Board, Declaration, LASTING};
    use jde_types::{Image, Text, Value as _};

    use super::*;

    #[test]
    fn a_message_keeps_its_value_while_newer_ones_are_written_and_read() {
        let value_type = Arc::new(Image::describe());
        let board = Board::new();
        let variable = board
            .declare(Declaration {
                owner: "camera".to_owned(),
                name: "image".to_owned(),
                value_type: Arc::clone(&value_type),
                unit: String::new(),
                doc: String::new(),
                access: Access::Export { validity: LASTING },
                limits: jde_abi::describe::Limits::default(),
                initial: None,
                writers: 1,
                readers: 1,
            })
            .unwrap();
        let mut writer = variable.writer(0, "camera").unwrap();
        let mut reader = ValueReader::new(&variable);
        assert!(reader.latch(0).is_none());
        let mut messages = Vec::new();
        for number in 0..6_u8 {
            let mut image = Image::boxed();
            image.encoding = Text::new("mono8");
            image.data.resize(100_000).fill(number);
            writer.loan().copy_from_slice(image.as_bytes());
            writer.publish(0, u64::MAX).unwrap();
            assert!(reader.latch(0).is_some());
            messages.push(reader.message());
            if number == 3 {
                messages.drain(..2);
            }
        }
        let read = |message: &ZBytes| {
            let pieces: Vec<_> = message.slices().collect();
            assert!(pieces.len() > 1, "the picture is not copied");
            let mut image = Image::boxed();
            cdr::decode_pieces(&value_type, &pieces, image.as_bytes_mut()).unwrap();
            assert_eq!((image.encoding.as_str(), image.data.len()), ("mono8", 100_000));
            assert!(image.data.iter().all(|pixel| *pixel == image.data[0]));
            image.data[0]
        };
        assert_eq!(messages.iter().map(read).collect::<Vec<_>>(), [2, 3, 4, 5]);
    }
}
