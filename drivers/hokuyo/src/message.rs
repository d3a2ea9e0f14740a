//! Messages of SCIP 2 on the wire: lines, checksums, and numbers encoded in letters. This module does not
//! interpret them.
//!
//! From Hokuyo's "Communication Protocol Specification for SCIP 2.0 Standard": a reply repeats the request
//! and adds a status line, data lines and an empty line. Each letter encodes 6 bits, starting with `0`.

/// Upper limit of a message, bytes. The longest has 1440 steps of three letters, a checksum and an end of
/// line per 64 letters, and the head.
const MAX_MESSAGE: usize = 8192;

/// A reply to a request, or a scan.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Message {
    /// The request, as the scanner received it.
    pub(crate) echo: String,
    /// Two letters; `00` is success, and `99` marks a scan.
    pub(crate) status: [u8; 2],
    /// Data lines, with their checksums.
    pub(crate) lines: Vec<Vec<u8>>,
}

/// Finds messages in the received bytes, however they are split and whatever lies between them.
#[derive(Debug, Default)]
pub(crate) struct Receiver {
    bytes: Vec<u8>,
    start: usize,
}

/// Returns the checksum letter of a line.
pub(crate) fn checksum(line: &[u8]) -> u8 {
    let sum = line.iter().fold(0_u8, |sum, byte| sum.wrapping_add(*byte));
    (sum & 0x3f) + 0x30
}

/// Returns a line without its checksum letter; `None` if the checksum is wrong.
pub(crate) fn checked(line: &[u8]) -> Option<&[u8]> {
    let (sum, text) = line.split_last()?;
    (checksum(text) == *sum).then_some(text)
}

/// Decodes a number from letters, the highest six bits first; `None` for invalid letters.
pub(crate) fn number(letters: &[u8]) -> Option<u32> {
    letters.iter().try_fold(0_u32, |number, letter| {
        let digit = letter.checked_sub(0x30).filter(|digit| *digit < 64)?;
        Some(number << 6 | u32::from(digit))
    })
}

impl Message {
    /// Returns the value of the data line `KEY:value;`.
    pub(crate) fn value(&self, key: &str) -> Option<&str> {
        self.lines.iter().find_map(|line| {
            let (text, sum) = line.split_at_checked(line.len().checked_sub(1)?)?;
            let bare = text.strip_suffix(b";")?;
            // Devices differ on whether the checksum includes the semicolon.
            if ![checksum(bare), checksum(text)].contains(&sum[0]) {
                return None;
            }
            core::str::from_utf8(bare)
                .ok()?
                .strip_prefix(key)?
                .strip_prefix(':')
        })
    }
}

impl Receiver {
    /// Appends received bytes.
    pub(crate) fn receive(&mut self, bytes: &[u8]) {
        self.bytes.drain(..self.start);
        self.start = 0;
        self.bytes.extend_from_slice(bytes);
    }

    /// Discards a partial message, which is invalid after a change of speed.
    pub(crate) fn clear(&mut self) {
        self.bytes.clear();
        self.start = 0;
    }

    /// Returns the next message; `None` until more bytes arrive.
    pub(crate) fn next(&mut self) -> Option<Message> {
        loop {
            let rest = &self.bytes[self.start..];
            let Some(end) = rest.windows(2).position(|pair| pair == b"\n\n") else {
                if rest.len() > MAX_MESSAGE {
                    // No message can be found in these bytes, except one that starts in their last line.
                    let line = rest
                        .iter()
                        .rposition(|byte| *byte == b'\n')
                        .unwrap_or(rest.len() - 1);
                    self.start += line + 1;
                }
                return None;
            };
            let message = message(&rest[..end]);
            self.start += end + 2;
            if message.is_some() {
                return message;
            }
        }
    }
}

fn message(bytes: &[u8]) -> Option<Message> {
    let mut lines = bytes
        .split(|byte| *byte == b'\n')
        .skip_while(|line| line.is_empty());
    let echo = core::str::from_utf8(lines.next()?).ok()?;
    let &[first, second] = checked(lines.next()?)? else {
        return None;
    };
    Some(Message {
        echo: echo.to_owned(),
        status: [first, second],
        lines: lines.map(<[u8]>::to_vec).collect(),
    })
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn checksums_and_numbers_are_those_of_the_specification() {
        assert_eq!(
            (checksum(b"00"), checksum(b"99"), checksum(b"0E")),
            (b'P', b'b', b'e')
        );
        // The examples of the specification: 1234 mm in two letters, 5432 mm in three.
        assert_eq!(number(b"CB"), Some(1234));
        assert_eq!(number(b"1Dh"), Some(5432));
        assert_eq!(number(b"0\x2f"), None);
        assert_eq!(number(b"0\x70"), None);
    }

    fn receive_all(pieces: &[&[u8]]) -> Vec<Message> {
        let mut receiver = Receiver::default();
        let mut messages = Vec::new();
        for piece in pieces {
            receiver.receive(piece);
            messages.extend(core::iter::from_fn(|| receiver.next()));
        }
        messages
    }

    const VERSION: &[u8] = b"VV\n00P\nVEND:Hokuyo Automatic Co.,Ltd.;[\nPROD:SOKUIKI Sensor URG-04LX;[\n\n";

    #[test]
    fn a_message_is_found_between_noise_and_empty_lines() {
        let messages = receive_all(&[b"\xff\x00\n\n\n\n", VERSION, b"half a line\n\nQT\n00P\n\n"]);
        let echoes: Vec<&str> = messages.iter().map(|message| &*message.echo).collect();
        assert_eq!(echoes, ["VV", "QT"]);
        assert_eq!((messages[0].status, messages[0].lines.len()), (*b"00", 2));
    }

    #[test]
    fn a_value_is_accepted_with_either_checksum_and_with_no_other() {
        let text = b"DMAX:5600";
        for (checked, good) in [(&text[..], true), (b"DMAX:5600;", true), (b"DMAX:5700", false)] {
            let line = [text, &b";"[..], &[checksum(checked)]].concat();
            let message = Message {
                echo: "PP".to_owned(),
                status: *b"00",
                lines: vec![line],
            };
            assert_eq!(message.value("DMAX"), good.then_some("5600"));
            assert_eq!(message.value("DMA"), None);
        }
    }

    #[test]
    fn endless_noise_is_discarded() {
        let mut receiver = Receiver::default();
        for _ in 0..1000 {
            receiver.receive(&[b'x'; 1000]);
            assert_eq!(receiver.next(), None);
        }
        assert!(receiver.bytes.len() <= MAX_MESSAGE + 2000);
        receiver.receive(b"\n\nQT\n00P\n\n");
        assert_eq!(receiver.next().map(|message| message.echo), Some("QT".to_owned()));
    }

    proptest! {
        #[test]
        fn messages_are_found_after_any_split(cut in 0..VERSION.len()) {
            let (head, tail) = VERSION.split_at(cut);
            prop_assert_eq!(receive_all(&[head, tail]), receive_all(&[VERSION]));
        }

        #[test]
        fn no_bytes_panic(pieces in prop::collection::vec(prop::collection::vec(prop_oneof![any::<u8>(), Just(b'\n'), Just(b';')], 0..300), 0..6)) {
            let pieces: Vec<&[u8]> = pieces.iter().map(|piece| &piece[..]).collect();
            for message in receive_all(&pieces) {
                message.value("DMAX");
            }
        }
    }
}
