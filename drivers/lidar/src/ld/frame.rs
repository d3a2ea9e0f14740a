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
