//! The Canon VC-C4 pan-tilt camera: its frames, which are sent inside TTY2 and return as bytes of an
//! auxiliary port.
//!
//! A unit of an angle is 0.1125 degrees, and a unit of a speed is 0.1125 degrees/s. The camera's positive
//! directions are up and to the right.

use crate::Error;

/// One unit of an angle or of a speed, rad or rad/s.
pub const UNIT: f64 = 0.1125 * core::f64::consts::PI / 180.0;

/// Longest frame that is decoded; the camera's own have at most 18 bytes.
const MAX_FRAME: usize = 32;

const FRAME_END: u8 = 0xEF;
const COMMAND_START: u8 = 0xFF;
const REPLY_START: u8 = 0xFE;
/// The device number of the only camera on its line, as two digits.
const DEVICE_NUMBER: [u8; 2] = [0x30, 0x30];
/// The angle 0 on the wire.
const ANGLE_ZERO: i32 = 0x8000;
/// The greatest zoom.
pub const MAX_ZOOM: u16 = 1960;

/// A command to the camera.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum HeadCommand {
    /// Power on or off.
    Power(bool),
    /// The serial line controls the camera, not the remote control.
    Control,
    /// Pan and tilt find their zero positions.
    Init,
    /// Pan speed, 8 to 800 units.
    PanSpeed(u16),
    /// Tilt speed, 8 to 662 units.
    TiltSpeed(u16),
    /// Pan and tilt stop.
    Stop,
    /// Turns to these angles.
    PanTilt {
        /// Units to the right, −875 to 875.
        pan: i16,
        /// Units up, −267 to 790.
        tilt: i16,
    },
    /// Limits the tilt to a range from now on, the lower limit first.
    TiltRange {
        /// Units up.
        min: i16,
        /// Units up.
        max: i16,
    },
    /// Requests pan and tilt.
    GetPanTilt,
    /// Zooms to a value, 0 to [`MAX_ZOOM`].
    Zoom(u16),
    /// Requests the present zoom.
    GetZoom,
    /// Requests the greatest zoom.
    GetMaxZoom,
    /// Sets the focus.
    Focus(Focus),
    /// Any other command.
    Other {
        /// Its code.
        code: u8,
        /// The bytes up to the end of the frame.
        data: Vec<u8>,
    },
}

/// The focus of a camera.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Focus {
    /// Automatic.
    Auto,
    /// Manual.
    Manual,
    /// Near.
    Near,
    /// Far.
    Far,
}

/// A reply of the camera.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct HeadReply {
    /// 0x30 done, 0x31 busy, 0x35 unknown command or parameter, 0x39 not possible in this mode.
    pub status: u8,
    /// The requested data.
    pub data: Vec<u8>,
}

/// A frame, in either direction.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum HeadFrame {
    /// To the camera.
    Command(HeadCommand),
    /// From the camera.
    Reply(HeadReply),
}

/// Finds frames in a stream of bytes. It skips bytes outside frames, and frames longer than 32 bytes.
#[derive(Clone, Debug, Default)]
pub struct HeadParser {
    buffer: Vec<u8>,
}

impl HeadCommand {
    /// Encodes the command as a frame.
    #[must_use]
    pub fn to_bytes(&self) -> Vec<u8> {
        let (code, data) = self.parts();
        let mut frame = vec![COMMAND_START, DEVICE_NUMBER[0], DEVICE_NUMBER[1], 0, code];
        frame.extend(data);
        frame.push(FRAME_END);
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
            Self::PanTilt { pan, tilt } => (
                0x62,
                [digits(encode_units(*pan), 4), digits(encode_units(*tilt), 4)].concat(),
            ),
            Self::TiltRange { min, max } => {
                let range = [digits(encode_units(*min), 4), digits(encode_units(*max), 4)];
                (0x64, [vec![0x31], range.concat()].concat())
            }
            Self::GetPanTilt => (0x63, Vec::new()),
            Self::Zoom(zoom) => (0xB3, digits(*zoom, 4)),
            Self::GetZoom => (0xB4, vec![0x30]),
            Self::GetMaxZoom => (0xB4, vec![0x33]),
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
            (0x62, data) => decode_pan_tilt(data).map(|(pan, tilt)| Self::PanTilt { pan, tilt }),
            (0x64, [0x31, range @ ..]) => decode_pan_tilt(range)
                .filter(|(min, max)| min <= max)
                .map(|(min, max)| Self::TiltRange { min, max }),
            (0x63, []) => Some(Self::GetPanTilt),
            (0xB3, [_, _, _, _]) => number(data).map(Self::Zoom),
            (0xB4, [0x30]) => Some(Self::GetZoom),
            (0xB4, [0x33]) => Some(Self::GetMaxZoom),
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

impl HeadReply {
    /// Status: done.
    pub const OK: u8 = 0x30;

    /// Creates the reply to a command that was executed and returns no data.
    #[must_use]
    pub fn success() -> Self {
        let (status, data) = (Self::OK, Vec::new());
        Self { status, data }
    }

    /// Creates the reply to [`HeadCommand::GetPanTilt`]: units to the right and up.
    #[must_use]
    pub fn position(pan: i16, tilt: i16) -> Self {
        Self {
            status: Self::OK,
            data: [digits(encode_units(pan), 4), digits(encode_units(tilt), 4)].concat(),
        }
    }

    /// Returns pan and tilt, in units to the right and up, if the reply contains them.
    #[must_use]
    pub fn pan_tilt(&self) -> Option<(i16, i16)> {
        decode_pan_tilt(&self.data)
    }

    /// Creates the reply to [`HeadCommand::GetZoom`] and [`HeadCommand::GetMaxZoom`].
    #[must_use]
    pub fn zoom(zoom: u16) -> Self {
        Self {
            status: Self::OK,
            data: digits(zoom, 4),
        }
    }

    /// Returns the zoom, if the reply contains one.
    #[must_use]
    pub fn zoomed(&self) -> Option<u16> {
        (self.data.len() == 4).then(|| number(&self.data))?
    }

    /// Encodes the reply as a frame.
    #[must_use]
    pub fn to_bytes(&self) -> Vec<u8> {
        let mut frame = vec![REPLY_START, DEVICE_NUMBER[0], DEVICE_NUMBER[1], self.status, 0];
        frame.extend(&self.data);
        frame.push(FRAME_END);
        frame
    }
}

impl HeadFrame {
    /// Decodes a whole frame.
    ///
    /// # Errors
    /// If it does not start or end like a frame, or is too short.
    pub fn from_bytes(frame: &[u8]) -> Result<Self, Error> {
        match frame {
            [COMMAND_START, _, _, _, code, data @ .., FRAME_END] => {
                Ok(Self::Command(HeadCommand::from_parts(*code, data)))
            }
            [REPLY_START, _, _, status, _, data @ .., FRAME_END] => Ok(Self::Reply(HeadReply {
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
    /// Processes bytes and calls `on_frame` with every frame that they complete.
    pub fn receive(&mut self, bytes: &[u8], mut on_frame: impl FnMut(HeadFrame)) {
        for byte in bytes {
            match byte {
                // Neither byte occurs within a frame, whose data are digits.
                &COMMAND_START | &REPLY_START => {
                    self.buffer.clear();
                    self.buffer.push(*byte);
                }
                _ if self.buffer.is_empty() => {}
                _ if self.buffer.len() == MAX_FRAME => self.buffer.clear(),
                &FRAME_END => {
                    self.buffer.push(FRAME_END);
                    if let Ok(frame) = HeadFrame::from_bytes(&self.buffer) {
                        on_frame(frame);
                    }
                    self.buffer.clear();
                }
                _ => self.buffer.push(*byte),
            }
        }
    }
}

fn encode_units(units: i16) -> u16 {
    (ANGLE_ZERO + i32::from(units)) as u16
}

fn decode_pan_tilt(data: &[u8]) -> Option<(i16, i16)> {
    let (pan, tilt) = data.split_at_checked(4)?;
    let decode_units = |digits: &[u8]| {
        let units = i32::from(number(digits)?) - ANGLE_ZERO;
        i16::try_from(units).ok()
    };
    (tilt.len() == 4).then_some(())?;
    Some((decode_units(pan)?, decode_units(tilt)?))
}

/// Returns hexadecimal digits in capital letters.
fn digits(value: u16, count: usize) -> Vec<u8> {
    format!("{value:0count$X}").into_bytes()
}

fn number(digits: &[u8]) -> Option<u16> {
    // Refuse a sign, which `from_str_radix` would accept.
    let is_hexadecimal = digits
        .iter()
        .all(|digit| matches!(digit, b'0'..=b'9' | b'A'..=b'F'));
    let text = core::str::from_utf8(digits).ok().filter(|_| is_hexadecimal)?;
    u16::from_str_radix(text, 16).ok()
}
