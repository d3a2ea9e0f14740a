//! Frames on the wire: checked, and found again after any garbage. This module knows no instants and does no I/O.
//!
//! From WIT-Motion's "WT901 Standard Communication Protocol": 0x55, the kind from 0x50 on, four numbers of 16 bits with a
//! sign, low byte first, and the sum of all bytes before it.

const HEAD: u8 = 0x55;
/// Bytes of a frame.
pub(crate) const SIZE: usize = 11;
/// The kinds that the protocol has: from the time to the quaternion and what satellites say.
const KINDS: core::ops::RangeInclusive<u8> = 0x50..=0x5f;

/// Four numbers of a kind.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Frame {
    pub(crate) kind: u8,
    pub(crate) numbers: [i16; 4],
    /// Whether a good frame precedes it without a byte between. A checksum of one byte is right by chance once in 256
    /// times: the first frame after garbage may be garbage.
    pub(crate) follows: bool,
}

/// What was found in the bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Received {
    Frame(Frame),
    /// The head of a frame whose contents are wrong.
    Corrupt,
}

/// Finds frames in the received bytes, however they are split and whatever lies between them.
#[derive(Debug, Default)]
pub(crate) struct Receiver {
    bytes: Vec<u8>,
    start: usize,
    /// Whether the last bytes were a good frame.
    is_locked: bool,
}

/// Returns the sum of the protocol.
pub(crate) fn checksum(bytes: &[u8]) -> u8 {
    bytes.iter().fold(0, |sum, byte| sum.wrapping_add(*byte))
}

impl Receiver {
    /// Appends received bytes.
    pub(crate) fn receive(&mut self, bytes: &[u8]) {
        self.bytes.drain(..self.start);
        self.start = 0;
        self.bytes.extend_from_slice(bytes);
    }

    /// Returns what was found next; `None` until more bytes arrive.
    pub(crate) fn next(&mut self) -> Option<Received> {
        loop {
            let rest = &self.bytes[self.start..];
            let (first, kind) = (*rest.first()?, rest.get(1));
            if first == HEAD && kind.is_none_or(|kind| KINDS.contains(kind)) {
                let frame = frame(rest.first_chunk::<SIZE>()?);
                self.start += if frame.is_some() { SIZE } else { 1 };
                let follows = core::mem::replace(&mut self.is_locked, frame.is_some());
                return Some(frame.map_or(Received::Corrupt, |(kind, numbers)| {
                    Received::Frame(Frame {
                        kind,
                        numbers,
                        follows,
                    })
                }));
            }
            self.start += 1;
            self.is_locked = false;
        }
    }
}

fn frame(bytes: &[u8; SIZE]) -> Option<(u8, [i16; 4])> {
    let number = |at: usize| i16::from_le_bytes([bytes[2 + 2 * at], bytes[3 + 2 * at]]);
    (checksum(&bytes[..SIZE - 1]) == bytes[SIZE - 1]).then(|| (bytes[1], core::array::from_fn(number)))
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::emulator::frame;

    /// One g upward, with 25 degrees Celsius.
    const EXAMPLE: [u8; SIZE] = [0x55, 0x51, 0x00, 0x00, 0x00, 0x00, 0x00, 0x08, 0xc4, 0x09, 0x7b];

    fn receive_all(pieces: &[&[u8]]) -> Vec<Received> {
        let mut receiver = Receiver::default();
        let mut all = Vec::new();
        for piece in pieces {
            receiver.receive(piece);
            all.extend(core::iter::from_fn(|| receiver.next()));
        }
        all
    }

    fn frames(bytes: &[u8]) -> Vec<Frame> {
        let frames = receive_all(&[bytes])
            .into_iter()
            .filter_map(|received| match received {
                Received::Frame(frame) => Some(frame),
                Received::Corrupt => None,
            });
        frames.collect()
    }

    #[test]
    fn a_frame_is_read_and_written_alike() {
        let [read] = frames(&EXAMPLE)[..] else {
            panic!("a frame is expected")
        };
        assert_eq!(
            (read.kind, read.numbers, read.follows),
            (0x51, [0, 0, 2048, 2500], false)
        );
        assert_eq!(frame(0x51, [0, 0, 2048, 2500]), EXAMPLE);
    }

    #[test]
    fn a_false_head_hides_no_frame_after_it_and_the_first_one_is_not_sure() {
        for false_head in [&[0x55][..], &[0x55, 0x51], &[0x55, 0x55, 0x53, 1, 2], &[7; 40]] {
            let found = frames(&[false_head, &EXAMPLE, &EXAMPLE].concat());
            assert_eq!(found.len(), 2, "{false_head:?}");
            assert_eq!(
                found.iter().map(|frame| frame.follows).collect::<Vec<_>>(),
                [false, true]
            );
        }
    }

    #[test]
    fn every_wrong_byte_is_noticed() {
        for index in 0..SIZE {
            for change in 1..=u8::MAX {
                let mut wrong = EXAMPLE;
                wrong[index] ^= change;
                assert_eq!(frames(&wrong), [], "byte {index} changed by {change}");
            }
        }
    }

    proptest! {
        #[test]
        fn frames_are_found_after_any_split(cut in 0..SIZE * 2, noise in prop::collection::vec(any::<u8>(), 0..40)) {
            let bytes = [&EXAMPLE[..], &noise, &EXAMPLE].concat();
            let (head, tail) = bytes.split_at(cut.min(bytes.len()));
            prop_assert_eq!(receive_all(&[head, tail]), receive_all(&[&bytes]));
        }
    }
}
