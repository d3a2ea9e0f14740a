//! An emulated lidar by the protocol's description, for tests: requests, modes, measurements of a room, and faults. It
//! does no I/O.

use std::time::Instant;

use jde_device::emulate::Emulator;

use super::samples::Format;

/// Measurements per second.
const RATE: f64 = 4000.0;
/// A correction of the angle of each measurement, in 1/8 degree.
const CORRECTION: u16 = 37;

/// The lidar.
#[derive(Clone, Debug)]
pub(crate) struct EmulatedRplidar {
    pub(crate) model: u8,
    /// The part after the point first.
    pub(crate) firmware: [u8; 2],
    pub(crate) serial_number: u8,
    /// Status and error.
    pub(crate) health: (u8, u16),
    pub(crate) baud: u32,
    /// The types of reply of its modes, and the mode that it recommends.
    pub(crate) modes: (Vec<u8>, u16),
    /// Commands that it does not answer.
    pub(crate) ignores: Vec<u8>,
    /// How many answers about what it is have a wrong byte.
    pub(crate) misread: u8,
    /// Turns per second.
    pub(crate) hertz: f64,
    /// The distance, mm, at an angle clockwise from ahead, degrees.
    pub(crate) distance: fn(f64) -> u16,
    pub(crate) scanning: Option<Format>,
    pub(crate) fault: Fault,
    /// Commands and their data, as they came.
    pub(crate) commands: Vec<(u8, Vec<u8>)>,
    pub(crate) angle: f64,
    pub(crate) due: f64,
    pub(crate) sent: usize,
    pub(crate) received: Vec<u8>,
    pub(crate) last: Option<Instant>,
}

/// What is wrong with the lidar or its line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Fault {
    None,
    /// It sends nothing, and its line stays open.
    Silent,
    /// One of so many bytes of measurements is wrong.
    Corrupt(usize),
    /// One of so many bytes of measurements is missing.
    Cut(usize),
}

impl EmulatedRplidar {
    /// An A1M8, which knows `EXPRESS_SCAN`, not turning yet.
    pub(crate) fn a1(distance: fn(f64) -> u16) -> Self {
        Self {
            model: 0x18,
            firmware: [29, 1],
            serial_number: 0xa0,
            health: (0, 0),
            baud: 115_200,
            modes: (vec![0x81, 0x82], 1),
            ignores: Vec::new(),
            misread: 0,
            hertz: 10.0,
            distance,
            scanning: None,
            fault: Fault::None,
            commands: Vec::new(),
            angle: 352.0,
            due: 0.0,
            sent: 0,
            received: Vec::new(),
            last: None,
        }
    }

    /// An S2, whose recommended mode is dense.
    pub(crate) fn s2(distance: fn(f64) -> u16) -> Self {
        Self {
            model: 0x71,
            baud: 1_000_000,
            modes: (vec![0x81, 0x85], 1),
            ..Self::a1(distance)
        }
    }

    fn answer(&mut self, command: u8, data: &[u8]) -> Vec<u8> {
        self.commands.push((command, data.to_vec()));
        if self.ignores.contains(&command) {
            return Vec::new();
        }
        match command {
            0x25 => {
                self.scanning = None;
                Vec::new()
            }
            // A lidar that has stopped to protect itself does not scan.
            0x20 | 0x82 if self.health.0 == 2 => Vec::new(),
            0x20 => self.scan(self.modes.0.first().copied().unwrap_or(0x81)),
            0x82 => {
                let mode = usize::from(data[0]);
                // Mode 0 is the only one before firmware 1.24.
                self.scan(if mode == 0 { 0x82 } else { self.modes.0[mode] })
            }
            0x50 => {
                let mut data = vec![self.model, self.firmware[0], self.firmware[1], 7];
                data.extend([self.serial_number; 16]);
                data[9] ^= self.misread;
                self.misread = self.misread.saturating_sub(1);
                reply(0x04, &data)
            }
            0x52 => {
                let [low, high] = self.health.1.to_le_bytes();
                reply(0x06, &[self.health.0, low, high])
            }
            0x84 => match data {
                [0x7c, 0, 0, 0] => reply(0x20, &[data, &self.modes.1.to_le_bytes()].concat()),
                [0x75, 0, 0, 0, mode, 0] => reply(0x20, &[0x75, 0, 0, 0, self.modes.0[usize::from(*mode)]]),
                _ => Vec::new(),
            },
            _ => Vec::new(),
        }
    }

    fn scan(&mut self, kind: u8) -> Vec<u8> {
        self.scanning = Format::of_kind(kind);
        vec![0xa5, 0x5a, if kind == 0x81 { 5 } else { 84 }, 0, 0, 0x40, kind]
    }

    /// Lets time pass, and returns what it measured.
    pub(crate) fn advance(&mut self, seconds: f64) -> Vec<u8> {
        let Some(format) = self.scanning.filter(|_| self.fault != Fault::Silent) else {
            self.due = 0.0;
            return Vec::new();
        };
        self.due += seconds * RATE;
        let group = match format {
            Format::Nodes => 1,
            Format::Express => 32,
            Format::Dense => 40,
        };
        let mut bytes = Vec::new();
        while self.due >= f64::from(group) {
            self.due -= f64::from(group);
            bytes.extend(self.measure(format, group));
        }
        bytes
            .into_iter()
            .filter_map(|byte| {
                self.sent += 1;
                match self.fault {
                    Fault::Corrupt(period) if self.sent.is_multiple_of(period) => {
                        // Equal changes would cancel each other in the checksum.
                        Some(byte ^ (self.sent / period % 255 + 1) as u8)
                    }
                    Fault::Cut(period) if self.sent.is_multiple_of(period) => None,
                    _ => Some(byte),
                }
            })
            .collect()
    }

    fn measure(&mut self, format: Format, group: u32) -> Vec<u8> {
        let step = 360.0 * self.hertz / RATE;
        let start = (self.angle * 64.0).round() as u16;
        let begins = self.angle < step;
        let angles: Vec<f64> = (0..group)
            .map(|index| self.angle + step * f64::from(index))
            .collect();
        self.angle = (self.angle + step * f64::from(group)).rem_euclid(360.0);
        let distance = |angle: f64| (self.distance)(angle.rem_euclid(360.0));
        if format == Format::Nodes {
            let [low, high] = (start << 1 | 1).to_le_bytes();
            let [near, far] = (distance(angles[0]) * 4).to_le_bytes();
            return vec![47 << 2 | if begins { 1 } else { 2 }, low, high, near, far];
        }
        let mut content = start.to_le_bytes().to_vec();
        if format == Format::Dense {
            content.extend(angles.iter().flat_map(|angle| distance(*angle).to_le_bytes()));
        } else {
            for pair in angles.chunks_exact(2) {
                for angle in pair {
                    let distance = distance(angle - f64::from(CORRECTION) / 8.0);
                    content.extend((distance << 2 | CORRECTION >> 4).to_le_bytes());
                }
                content.push((CORRECTION & 0xf | (CORRECTION & 0xf) << 4) as u8);
            }
        }
        let sum = content.iter().fold(0, |sum, byte| sum ^ byte);
        [&[0xa0 | sum & 0xf, 0x50 | sum >> 4], &*content].concat()
    }
}

impl Emulator for EmulatedRplidar {
    fn receive(&mut self, bytes: &[u8], baud: u32) -> Vec<u8> {
        if baud != self.baud {
            return vec![0xf8, 0x00, 0xa5];
        }
        if self.fault == Fault::Silent {
            return Vec::new();
        }
        self.received.extend_from_slice(bytes);
        let mut replies = Vec::new();
        while let [0xa5, command, rest @ ..] = &*self.received {
            let (command, size) = (
                *command,
                if command & 0x80 == 0 {
                    0
                } else {
                    usize::from(rest[0]) + 2
                },
            );
            let Some(data) = rest.get(..size).map(<[u8]>::to_vec) else {
                break;
            };
            let all: Vec<u8> = self.received.drain(..2 + size).collect();
            let data = if size == 0 { &data[..] } else { &data[1..size - 1] };
            let sum = all.iter().fold(0, |sum, byte| sum ^ byte);
            assert!(size == 0 || sum == 0, "the checksum of a request");
            replies.extend(self.answer(command, data));
            if command == 0x25 {
                // It misses what follows a stop within a millisecond.
                self.received.clear();
            }
        }
        replies
    }

    fn poll_output(&mut self) -> Vec<u8> {
        let now = Instant::now();
        let passed = self
            .last
            .replace(now)
            .map_or(0.0, |last| (now - last).as_secs_f64());
        self.advance(passed)
    }
}

fn reply(kind: u8, data: &[u8]) -> Vec<u8> {
    [&[0xa5, 0x5a, data.len() as u8, 0, 0, 0, kind], data].concat()
}
