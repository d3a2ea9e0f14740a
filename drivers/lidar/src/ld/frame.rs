//! Frames on the wire: checked, and found again after any garbage. This module knows no turns and does no I/O.
//!
//! From LDRobot's "LD06 Development Manual": 0x54, 0x2C, speed in degrees/s, start angle in 0.01 degrees, twelve
//! points of a distance in mm and an intensity, end angle, time in ms that wraps at 30000, and a checksum of all bytes
//! before it. Numbers are sent low byte first.

const HEAD: [u8; 2] = [0x54, 0x2c];
/// Points of a frame.
pub(crate) const POINTS: usize = 12;
/// Bytes of a frame.
pub(crate) const SIZE: usize = 47;
/// The time of frames wraps at this number, ms.
pub(crate) const WRAP: u16 = 30_000;
/// Greatest angle of a frame, degrees. At 2300 points and 13 turns a second it is 22.
const MAX_SPAN: f64 = 24.0;
/// The polynomial of the CRC-8, whose highest bit is sent first and which starts with 0.
const POLYNOMIAL: u8 = 0x4d;

/// Twelve points.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Frame {
    /// Degrees per second.
    pub(crate) speed: u16,
    /// Clockwise from straight ahead, degrees.
    pub(crate) start: f64,
    /// From the first point to the last, degrees.
    pub(crate) span: f64,
    /// Distance, mm, where 0 is none, and intensity.
    pub(crate) points: [(u16, u8); POINTS],
    /// The lidar's clock, ms.
    pub(crate) stamp: u16,
}

/// What was found in the bytes.
#[derive(Clone, Copy, Debug, PartialEq)]
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
}

/// Returns the checksum of the manual.
pub(crate) fn checksum(bytes: &[u8]) -> u8 {
    bytes.iter().fold(0, |sum, byte| {
        (0..8).fold(sum ^ byte, |sum, _| {
            let carry = if sum & 0x80 == 0 { 0 } else { POLYNOMIAL };
            sum << 1 ^ carry
        })
    })
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
            let head = rest.get(..HEAD.len());
            if head.map_or(rest.first() == Some(&HEAD[0]), |head| head == HEAD) {
                let frame = frame(rest.first_chunk::<SIZE>()?);
                self.start += if frame.is_some() { SIZE } else { 1 };
                return Some(frame.map_or(Received::Corrupt, Received::Frame));
            }
            rest.first()?;
            self.start += 1;
        }
    }
}

/// Reads a frame. A checksum of one byte is right by chance once in 256 times, so the numbers must be possible, too.
fn frame(bytes: &[u8; SIZE]) -> Option<Frame> {
    let number = |at: usize| u16::from_le_bytes([bytes[at], bytes[at + 1]]);
    let (start, end, stamp) = (number(4), number(42), number(44));
    let span = (f64::from(end) - f64::from(start)).rem_euclid(36_000.0) / 100.0;
    let is_possible = start <= 36_000 && end <= 36_000 && stamp <= WRAP && span <= MAX_SPAN;
    (is_possible && checksum(&bytes[..SIZE - 1]) == bytes[SIZE - 1]).then(|| Frame {
        speed: number(2),
        start: f64::from(start) / 100.0,
        span,
        points: core::array::from_fn(|point| (number(6 + 3 * point), bytes[8 + 3 * point])),
        stamp,
    })
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    /// The example of the manual.
    const EXAMPLE: [u8; SIZE] = [
        0x54, 0x2c, 0x68, 0x08, 0xab, 0x7e, 0xe0, 0x00, 0xe4, 0xdc, 0x00, 0xe2, 0xd9, 0x00, 0xe5, 0xd5, 0x00,
        0xe3, 0xd3, 0x00, 0xe4, 0xd0, 0x00, 0xe9, 0xcd, 0x00, 0xe4, 0xca, 0x00, 0xe2, 0xc7, 0x00, 0xe9, 0xc5,
        0x00, 0xe5, 0xc2, 0x00, 0xe5, 0xc0, 0x00, 0xe5, 0xbe, 0x82, 0x3a, 0x1a, 0x50,
    ];

    fn receive_all(pieces: &[&[u8]]) -> Vec<Received> {
        let mut receiver = Receiver::default();
        let mut all = Vec::new();
        for piece in pieces {
            receiver.receive(piece);
            all.extend(core::iter::from_fn(|| receiver.next()));
        }
        all
    }

    fn frames(bytes: &[u8]) -> usize {
        let all = receive_all(&[bytes]);
        let is_frame = |received: &&Received| matches!(received, Received::Frame(_));
        all.iter().filter(is_frame).count()
    }

    #[test]
    fn the_example_of_the_manual_is_read() {
        let [Received::Frame(frame)] = receive_all(&[&EXAMPLE])[..] else {
            panic!("a frame is expected")
        };
        assert_eq!((frame.speed, frame.start, frame.stamp), (2152, 324.27, 6714));
        assert!((frame.span - 10.43).abs() < 1e-9);
        assert_eq!((frame.points[0], frame.points[11]), ((224, 228), (192, 229)));
    }

    #[test]
    fn a_false_head_hides_no_frame_after_it() {
        for false_head in [&[0x54][..], &[0x54, 0x2c], &[0x54, 0x54, 0x2c, 1, 2]] {
            assert_eq!(frames(&[false_head, &EXAMPLE, &EXAMPLE].concat()), 2);
        }
    }

    #[test]
    fn every_wrong_byte_is_noticed() {
        for index in 0..SIZE {
            for change in 1..=u8::MAX {
                let mut wrong = EXAMPLE;
                wrong[index] ^= change;
                assert_eq!(frames(&wrong), 0, "byte {index} changed by {change}");
            }
        }
    }

    #[test]
    fn impossible_numbers_are_rejected_despite_their_checksum() {
        for (at, number) in [(4, 36_001_u16), (42, 36_001), (44, 30_001), (42, 32_427 + 2401)] {
            let mut wrong = EXAMPLE;
            wrong[at..at + 2].copy_from_slice(&number.to_le_bytes());
            wrong[SIZE - 1] = checksum(&wrong[..SIZE - 1]);
            assert_eq!(frames(&wrong), 0, "{number} at {at}");
        }
    }

    proptest! {
        #[test]
        fn frames_are_found_after_any_split(cut in 0..SIZE * 2, noise in prop::collection::vec(any::<u8>(), 0..60)) {
            let bytes = [&EXAMPLE[..], &noise, &EXAMPLE].concat();
            let (head, tail) = bytes.split_at(cut.min(bytes.len()));
            prop_assert_eq!(receive_all(&[head, tail]), receive_all(&[&bytes]));
        }
    }
}
