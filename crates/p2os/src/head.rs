//! The Canon VC-C4 pan-tilt camera: its frames, which travel inside TTY2 and come back as bytes of an
//! auxiliary port.
//!
//! A unit of an angle is 0.1125 degrees, of a speed 0.1125 degrees/s. Up and to the right are positive for
//! the camera.

use crate::Error;

/// What one unit of an angle or of a speed is, rad or rad/s.
pub const UNIT: f64 = 0.1125 * core::f64::consts::PI / 180.0;

/// Longest frame that is understood; the camera's own have at most 18 bytes.
const LONGEST: usize = 32;

const END: u8 = 0xEF;
const COMMAND: u8 = 0xFF;
const ANSWER: u8 = 0xFE;
/// The device number of a camera alone on its line, as two digits.
const DEVICE: [u8; 2] = [0x30, 0x30];
/// What an angle of 0 is on the wire.
const MIDDLE: i32 = 0x8000;
/// The farthest that it zooms.
pub const MOST_ZOOM: u16 = 1960;

/// A command to the camera.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum HeadCommand {
    /// Power on or off.
    Power(bool),
    /// The line, not the remote control, commands.
    Control,
    /// Pan and tilt find their zeros.
    Init,
    /// Speed of panning, 8 to 800 units.
    PanSpeed(u16),
    /// Speed of tilting, 8 to 662 units.
    TiltSpeed(u16),
    /// Pan and tilt stop.
    Stop,
    /// Turns to a place.
    PanTilt {
        /// Units to the right, −875 to 875.
        pan: i16,
        /// Units up, −267 to 790.
        tilt: i16,
    },
    /// Keeps the tilt between two places from now on, the lower one first.
    TiltRange {
        /// Units up.
        least: i16,
        /// Units up.
        most: i16,
    },
    /// Asks where it looks.
    Where,
    /// Zooms to a place, 0 to [`MOST_ZOOM`].
    Zoom(u16),
    /// Asks how far it has zoomed.
    Zoomed,
    /// Asks how far it can zoom.
    MostZoom,
    /// What it shall be sharp at.
    Focus(Focus),
    /// Any other.
    Other {
        /// Its code.
        code: u8,
        /// What follows, up to the end of the frame.
        data: Vec<u8>,
    },
}

/// What a camera is sharp at.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Focus {
    /// What it finds by itself.
    Auto,
    /// What somebody turns it to.
    Manual,
    /// What is near.
    Near,
    /// What is far.
    Far,
}

/// What the camera answers.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct HeadAnswer {
    /// 0x30 done, 0x31 busy, 0x35 no such command or parameter, 0x39 not in this mode.
    pub status: u8,
    /// What was asked for.
    pub data: Vec<u8>,
}

/// What one end of the line said to the other.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum HeadFrame {
    /// To the camera.
    Command(HeadCommand),
    /// From the camera.
    Answer(HeadAnswer),
}

/// Finds frames in a stream of bytes; bytes outside them are skipped, and so is a frame that does not end in
/// time.
#[derive(Clone, Debug, Default)]
pub struct HeadParser {
    held: Vec<u8>,
}

impl HeadCommand {
    /// The frame that says it.
    #[must_use]
    pub fn to_bytes(&self) -> Vec<u8> {
        let (code, data) = self.parts();
        let mut frame = vec![COMMAND, DEVICE[0], DEVICE[1], 0, code];
        frame.extend(data);
        frame.push(END);
        frame
    }

    fn parts(&self) -> (u8, Vec<u8>) {
        match self {
            Self::Power(on) => (0xA0, vec![0x30 + u8::from(*on)]),
            Self::Control => (0x90, vec![0x30]),
            Self::Init => (0x58, vec![0x30]),
            Self::PanSpeed(speed) => (0x50, digits((*speed).min(0xFFF), 3)),
            Self::TiltSpeed(speed) => (0x51, digits((*speed).min(0xFFF), 3)),
            Self::Stop => (0x53, vec![0x30]),
            Self::PanTilt { pan, tilt } => (0x62, [digits(place(*pan), 4), digits(place(*tilt), 4)].concat()),
            Self::TiltRange { least, most } => {
                let places = [digits(place(*least), 4), digits(place(*most), 4)];
                (0x64, [vec![0x31], places.concat()].concat())
            }
            Self::Where => (0x63, Vec::new()),
            Self::Zoom(zoom) => (0xB3, digits(*zoom, 4)),
            Self::Zoomed => (0xB4, vec![0x30]),
            Self::MostZoom => (0xB4, vec![0x33]),
            Self::Focus(focus) => (0xA1, vec![0x30 + *focus as u8]),
            Self::Other { code, data } => (*code, data.clone()),
        }
    }

    fn from_parts(code: u8, data: &[u8]) -> Self {
        let typed = match (code, data) {
            (0xA0, [on @ 0x30..=0x31]) => Some(Self::Power(*on == 0x31)),
            (0x90, [0x30]) => Some(Self::Control),
            (0x58, [0x30]) => Some(Self::Init),
            (0x50, [_, _, _]) => number(data).map(Self::PanSpeed),
            (0x51, [_, _, _]) => number(data).map(Self::TiltSpeed),
            (0x53, [0x30]) => Some(Self::Stop),
            (0x62, data) => places(data).map(|(pan, tilt)| Self::PanTilt { pan, tilt }),
            (0x64, [0x31, range @ ..]) => places(range)
                .filter(|(least, most)| least <= most)
                .map(|(least, most)| Self::TiltRange { least, most }),
            (0x63, []) => Some(Self::Where),
            (0xB3, [_, _, _, _]) => number(data).map(Self::Zoom),
            (0xB4, [0x30]) => Some(Self::Zoomed),
            (0xB4, [0x33]) => Some(Self::MostZoom),
            (0xA1, [0x30]) => Some(Self::Focus(Focus::Auto)),
            (0xA1, [0x31]) => Some(Self::Focus(Focus::Manual)),
            (0xA1, [0x32]) => Some(Self::Focus(Focus::Near)),
            (0xA1, [0x33]) => Some(Self::Focus(Focus::Far)),
            _ => None,
        };
        typed.unwrap_or_else(|| Self::Other {
            code,
            data: data.to_vec(),
        })
    }
}

impl HeadAnswer {
    /// Status: done.
    pub const OK: u8 = 0x30;

    /// The answer to what was done, without anything to tell.
    #[must_use]
    pub fn done() -> Self {
        let (status, data) = (Self::OK, Vec::new());
        Self { status, data }
    }

    /// The answer to [`HeadCommand::Where`]: units to the right and up.
    #[must_use]
    pub fn place(pan: i16, tilt: i16) -> Self {
        Self {
            status: Self::OK,
            data: [digits(place(pan), 4), digits(place(tilt), 4)].concat(),
        }
    }

    /// Units to the right and up, if that is what it tells.
    #[must_use]
    pub fn pan_tilt(&self) -> Option<(i16, i16)> {
        places(&self.data)
    }

    /// The answer to [`HeadCommand::Zoomed`] and [`HeadCommand::MostZoom`].
    #[must_use]
    pub fn zoom(zoom: u16) -> Self {
        Self {
            status: Self::OK,
            data: digits(zoom, 4),
        }
    }

    /// How far it has or can zoom, if that is what it tells.
    #[must_use]
    pub fn zoomed(&self) -> Option<u16> {
        (self.data.len() == 4).then(|| number(&self.data))?
    }

    /// The frame that says it.
    #[must_use]
    pub fn to_bytes(&self) -> Vec<u8> {
        let mut frame = vec![ANSWER, DEVICE[0], DEVICE[1], self.status, 0];
        frame.extend(&self.data);
        frame.push(END);
        frame
    }
}

impl HeadFrame {
    /// Understands a whole frame.
    ///
    /// # Errors
    /// If it does not begin or end as frames do, or is too short.
    pub fn from_bytes(frame: &[u8]) -> Result<Self, Error> {
        match frame {
            [COMMAND, _, _, _, code, data @ .., END] => {
                Ok(Self::Command(HeadCommand::from_parts(*code, data)))
            }
            [ANSWER, _, _, status, _, data @ .., END] => Ok(Self::Answer(HeadAnswer {
                status: *status,
                data: data.to_vec(),
            })),
            _ => Err(Error::Short {
                what: "frame of the camera",
            }),
        }
    }
}

impl HeadParser {
    /// Takes bytes as they come and gives each frame they complete to `each`.
    pub fn receive(&mut self, bytes: &[u8], mut each: impl FnMut(HeadFrame)) {
        for byte in bytes {
            match byte {
                // Neither occurs within a frame, whose data are digits.
                &COMMAND | &ANSWER => {
                    self.held.clear();
                    self.held.push(*byte);
                }
                _ if self.held.is_empty() => {}
                _ if self.held.len() == LONGEST => self.held.clear(),
                &END => {
                    self.held.push(END);
                    if let Ok(frame) = HeadFrame::from_bytes(&self.held) {
                        each(frame);
                    }
                    self.held.clear();
                }
                _ => self.held.push(*byte),
            }
        }
    }
}

fn place(units: i16) -> u16 {
    (MIDDLE + i32::from(units)) as u16
}

fn places(data: &[u8]) -> Option<(i16, i16)> {
    let (pan, tilt) = data.split_at_checked(4)?;
    let place = |digits: &[u8]| {
        let units = i32::from(number(digits)?) - MIDDLE;
        i16::try_from(units).ok()
    };
    (tilt.len() == 4).then_some(())?;
    Some((place(pan)?, place(tilt)?))
}

/// Hexadecimal digits, capital letters.
fn digits(value: u16, count: usize) -> Vec<u8> {
    format!("{value:0count$X}").into_bytes()
}

fn number(digits: &[u8]) -> Option<u16> {
    // No sign, which the parser of numbers would take.
    let all = digits
        .iter()
        .all(|digit| matches!(digit, b'0'..=b'9' | b'A'..=b'F'));
    let text = core::str::from_utf8(digits).ok().filter(|_| all)?;
    u16::from_str_radix(text, 16).ok()
}
