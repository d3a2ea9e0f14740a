//! An emulated lidar by the manual, for tests: frames of a room, and faults. It does no I/O.

use std::collections::VecDeque;
use std::time::Instant;

use jde_device::emulate::Emulator;

use super::frame::{POINTS, SIZE, WRAP, checksum};

/// Points per second.
const RATE: f64 = 4500.0;
/// Frames that a line repeats: the four KiB that an adapter or a system keeps, which hold two whole turns.
const REPEATED: usize = 4096 / SIZE;

/// The lidar.
#[derive(Clone, Debug)]
pub(crate) struct EmulatedLd {
    /// Turns per second.
    pub(crate) hertz: f64,
    /// The distance, mm, at an angle clockwise from ahead, degrees.
    pub(crate) distance: fn(f64) -> u16,
    /// Angle of the next point, degrees.
    pub(crate) angle: f64,
    /// Its clock, ms.
    pub(crate) clock: f64,
    pub(crate) fault: Fault,
    pub(crate) sent: usize,
    /// The last frames.
    pub(crate) recent: VecDeque<[u8; SIZE]>,
    /// When the lidar started, and how many frames it has sent since, in real time.
    pub(crate) real: Option<(Instant, usize)>,
}

/// What is wrong with the lidar or its line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Fault {
    None,
    /// It sends nothing, and its line stays open.
    Silent,
    /// A byte of every frame whose number has this remainder below the divisor is wrong.
    Corrupt {
        below: usize,
        divisor: usize,
    },
    /// Every frame of so many is missing.
    Missing(usize),
    /// Bytes that are no frame precede each frame, among them a false head.
    Noisy,
    /// The bytes are those of another speed of the line.
    OtherBaud,
    /// Its clock stands still.
    ClockStands,
    /// The same frames come again and again.
    Repeats,
}

/// A frame of these values.
pub(crate) fn frame(speed: u16, angles: [f64; 2], points: [(u16, u8); POINTS], stamp: u16) -> [u8; SIZE] {
    let mut bytes = [0; SIZE];
    let [start, end] =
        angles.map(|angle| ((angle.rem_euclid(360.0) * 100.0).round() as u16 % 36_000).to_le_bytes());
    bytes[..2].copy_from_slice(&[0x54, 0x2c]);
    bytes[2..4].copy_from_slice(&speed.to_le_bytes());
    bytes[4..6].copy_from_slice(&start);
    for (place, (distance, intensity)) in bytes[6..42].chunks_exact_mut(3).zip(points) {
        place[..2].copy_from_slice(&distance.to_le_bytes());
        place[2] = intensity;
    }
    bytes[42..44].copy_from_slice(&end);
    bytes[44..46].copy_from_slice(&stamp.to_le_bytes());
    bytes[46] = checksum(&bytes[..46]);
    bytes
}

impl EmulatedLd {
    /// A lidar in the middle of a turn, shortly before its clock wraps.
    pub(crate) fn new(distance: fn(f64) -> u16) -> Self {
        Self {
            hertz: 10.0,
            distance,
            angle: 352.0,
            clock: 29_900.0,
            fault: Fault::None,
            sent: 0,
            recent: VecDeque::new(),
            real: None,
        }
    }

    fn next_frame(&mut self) -> [u8; SIZE] {
        let step = 360.0 * self.hertz / RATE;
        let angle = |point: usize| (self.angle + step * point as f64).rem_euclid(360.0);
        let points = core::array::from_fn(|point| ((self.distance)(angle(point)), point as u8 + 100));
        let angles = [angle(0), angle(POINTS - 1)];
        if self.fault != Fault::ClockStands {
            self.clock = (self.clock + POINTS as f64 / RATE * 1000.0).rem_euclid(f64::from(WRAP));
        }
        self.angle = angle(POINTS);
        frame(
            (self.hertz * 360.0).round() as u16,
            angles,
            points,
            self.clock as u16,
        )
    }

    /// Returns what arrives in the time of a frame.
    pub(crate) fn next_output(&mut self) -> Vec<u8> {
        self.sent += 1;
        let oldest = if self.recent.len() < REPEATED {
            None
        } else {
            self.recent.pop_front()
        };
        let frame = match oldest {
            Some(frame) if self.fault == Fault::Repeats => frame,
            _ => self.next_frame(),
        };
        self.recent.push_back(frame);
        let mut frame = frame.to_vec();
        match self.fault {
            Fault::None | Fault::ClockStands | Fault::Repeats => frame,
            Fault::Silent => Vec::new(),
            Fault::Corrupt { below, divisor } => {
                if self.sent % divisor < below {
                    frame[30] ^= 0x10;
                }
                frame
            }
            Fault::Missing(divisor) if self.sent.is_multiple_of(divisor) => Vec::new(),
            Fault::Missing(_) => frame,
            Fault::Noisy => [&[0x00, 0x54, 0xff, 0x54, 0x2c, 0x07][..], &frame].concat(),
            Fault::OtherBaud => frame.iter().map(|byte| byte.rotate_left(3) ^ 0xa5).collect(),
        }
    }

    /// Sends a number of turns at once.
    pub(crate) fn turns(&mut self, turns: f64) -> Vec<u8> {
        let frames = (turns * RATE / self.hertz / POINTS as f64).ceil() as usize;
        (0..frames).flat_map(|_| self.next_output()).collect()
    }
}

impl Emulator for EmulatedLd {
    fn receive(&mut self, _: &[u8], _: u32) -> Vec<u8> {
        panic!("the lidar takes no commands")
    }

    fn poll_output(&mut self) -> Vec<u8> {
        let (start, sent) = self.real.unwrap_or((Instant::now(), 0));
        let due = (start.elapsed().as_secs_f64() * RATE) as usize / POINTS;
        self.real = Some((start, due));
        (sent..due).flat_map(|_| self.next_output()).collect()
    }
}
