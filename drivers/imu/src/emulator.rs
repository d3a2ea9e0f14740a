//! An emulated unit by the public protocol, for tests: sets of frames, and faults. It does no I/O.

use std::time::Instant;

use jde_device::emulate::Emulator;

use crate::frame::{SIZE, checksum};
use crate::set::{ACCELERATION, ANGLES, QUATERNION, RATES};

/// The unit.
#[derive(Clone, Debug)]
pub(crate) struct EmulatedWit {
    /// Sets in a second.
    pub(crate) hertz: f64,
    /// Turn rates, degrees/s.
    pub(crate) rates: [f64; 3],
    /// Roll, pitch and yaw, degrees.
    pub(crate) angles: [f64; 3],
    pub(crate) has_quaternion: bool,
    pub(crate) fault: Fault,
    pub(crate) sent: usize,
    /// When the unit started, and how many sets it has sent since, in real time.
    pub(crate) real: Option<(Instant, usize)>,
}

/// What is wrong with the unit or its line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Fault {
    None,
    /// It sends nothing, and its line stays open.
    Silent,
    /// A byte of every frame of most sets is wrong.
    Corrupt,
    /// A byte of the turn rates of every tenth set is wrong.
    Rarely,
    /// The bytes are those of another speed of the line.
    OtherBaud,
    /// The same set comes again and again.
    Repeats,
    /// It sends no turn rates.
    NoRates,
    /// It turns as fast as its numbers go.
    Saturated,
}

/// A frame of these values.
pub(crate) fn frame(kind: u8, numbers: [i16; 4]) -> [u8; SIZE] {
    let mut bytes = [0; SIZE];
    (bytes[0], bytes[1]) = (0x55, kind);
    for (place, number) in bytes[2..10].chunks_exact_mut(2).zip(numbers) {
        place.copy_from_slice(&number.to_le_bytes());
    }
    bytes[10] = checksum(&bytes[..10]);
    bytes
}

impl EmulatedWit {
    pub(crate) const fn new() -> Self {
        Self {
            hertz: 100.0,
            rates: [0.0; 3],
            angles: [0.0; 3],
            has_quaternion: false,
            fault: Fault::None,
            sent: 0,
            real: None,
        }
    }

    /// Returns the bytes of the next set.
    pub(crate) fn next_output(&mut self) -> Vec<u8> {
        if self.fault != Fault::Repeats {
            self.sent += 1;
        }
        let scaled =
            |value: f64, range: f64| (value / range * 32768.0).round().clamp(-32768.0, 32767.0) as i16;
        // The last bits of a real one are noise.
        let noise = (self.sent * 7 % 5) as i16;
        let rates = if self.fault == Fault::Saturated {
            [2000.0; 3]
        } else {
            self.rates
        };
        let angles = self.angles.map(|angle| scaled(angle, 180.0));
        let [roll, pitch, yaw] = self.angles.map(|angle| libm::sincos(angle.to_radians() / 2.0));
        let quaternion = [
            roll.1 * pitch.1 * yaw.1 + roll.0 * pitch.0 * yaw.0,
            roll.0 * pitch.1 * yaw.1 - roll.1 * pitch.0 * yaw.0,
            roll.1 * pitch.0 * yaw.1 + roll.0 * pitch.1 * yaw.0,
            roll.1 * pitch.1 * yaw.0 - roll.0 * pitch.0 * yaw.1,
        ];
        let mut frames = vec![
            frame(ACCELERATION, [noise, 0, 2048, 2500]),
            frame(
                RATES,
                [
                    scaled(rates[0], 2000.0),
                    scaled(rates[1], 2000.0),
                    scaled(rates[2], 2000.0),
                    2500,
                ],
            ),
            frame(ANGLES, [angles[0], angles[1], angles[2], 0x4711]),
        ];
        if self.has_quaternion {
            frames.push(frame(QUATERNION, quaternion.map(|part| scaled(part, 1.0))));
        }
        match self.fault {
            Fault::NoRates => {
                frames.remove(1);
            }
            Fault::Corrupt if !self.sent.is_multiple_of(4) => {
                frames.iter_mut().for_each(|frame| frame[5] ^= 0x10)
            }
            Fault::Rarely if self.sent.is_multiple_of(10) => frames[1][5] ^= 0x10,
            _ => {}
        }
        let bytes = frames.concat();
        match self.fault {
            Fault::Silent => Vec::new(),
            Fault::OtherBaud => bytes.iter().map(|byte| byte.rotate_left(3) & 0xa8).collect(),
            _ => bytes,
        }
    }
}

impl Emulator for EmulatedWit {
    fn receive(&mut self, _: &[u8], _: u32) -> Vec<u8> {
        panic!("the driver sends the unit nothing")
    }

    fn poll_output(&mut self) -> Vec<u8> {
        let (start, sent) = self.real.unwrap_or((Instant::now(), 0));
        let due = (start.elapsed().as_secs_f64() * self.hertz) as usize;
        self.real = Some((start, due));
        (sent..due).flat_map(|_| self.next_output()).collect()
    }
}
