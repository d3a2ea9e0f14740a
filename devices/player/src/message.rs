//! Messages on the stream: the greeting of the server, then headers of 40 bytes with their bodies. This
//! module does not interpret bodies.

use crate::wire::FixedValue;
use crate::{Device, Error, Interface};

/// Length of a header, bytes.
pub const HEADER: usize = 40;
/// Longest body that a session accepts, bytes. A list of the 4096 devices that a server can have takes 64
/// KiB, and a scan of 100 000 beams 800 KB.
pub const MAX_BODY: usize = 1 << 20;

/// Length of the greeting, bytes.
const GREETING_BYTES: usize = 32;
/// How it begins; the version follows.
const GREETING_START: &[u8] = b"Player v.";

/// The kind of a message.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// From a device, unsolicited.
    Data,
    /// To a device, without a reply.
    Command,
    /// To a device, with a reply.
    Request,
    /// The reply to a request that was carried out.
    Accepted,
    /// A mark between data that were requested.
    Synch,
    /// The reply to a request that was not carried out.
    Refused,
}

/// A message.
#[derive(Clone, Debug, PartialEq)]
pub struct Message {
    /// Its sender or its receiver.
    pub device: Device,
    /// Its kind.
    pub kind: Kind,
    /// Its meaning within the kind, by the interface.
    pub subtype: u8,
    /// The server's time, s.
    pub stamp: f64,
    /// Its fields.
    pub body: Vec<u8>,
}

/// Finds messages in the received bytes, however they are split.
#[derive(Clone, Debug, Default)]
pub struct Receiver {
    bytes: Vec<u8>,
    version: Option<String>,
}

impl Kind {
    const ALL: [Self; 6] = [
        Self::Data,
        Self::Command,
        Self::Request,
        Self::Accepted,
        Self::Synch,
        Self::Refused,
    ];

    fn from_code(code: u32) -> Option<Self> {
        Self::ALL.into_iter().find(|kind| kind.code() == code)
    }

    fn code(self) -> u32 {
        self as u32 + 1
    }
}

impl Message {
    /// Returns a message to a device. The server fills in host, port and time itself.
    #[must_use]
    pub fn to(device: Device, kind: Kind, subtype: u8, body: Vec<u8>) -> Self {
        Self {
            device,
            kind,
            subtype,
            stamp: 0.0,
            body,
        }
    }

    /// Returns the bytes on the stream.
    #[must_use]
    pub fn to_bytes(&self) -> Vec<u8> {
        let mut bytes = Vec::with_capacity(HEADER + self.body.len());
        let address = [0, 0, self.device.interface.0.into(), self.device.index.into()];
        for number in address.into_iter().chain([self.kind.code(), self.subtype.into()]) {
            bytes.extend(number.to_be_bytes());
        }
        bytes.extend(self.stamp.to_be_bytes());
        bytes.extend(0_u32.to_be_bytes());
        bytes.extend((self.body.len() as u32).to_be_bytes());
        bytes.extend(&self.body);
        bytes
    }
}

impl Receiver {
    /// Returns the version of the server, once it has greeted.
    #[must_use]
    pub fn version(&self) -> Option<&str> {
        self.version.as_deref()
    }

    /// Appends received bytes. `take` receives every message that is complete.
    ///
    /// # Errors
    /// If the bytes are not those of a Player server of version 3. The stream is useless then.
    pub fn receive(&mut self, bytes: &[u8], mut take: impl FnMut(Message)) -> Result<(), Error> {
        self.bytes.extend_from_slice(bytes);
        let mut rest = &self.bytes[..];
        if self.version.is_none() {
            let Some(version) = greeting(rest)? else {
                return Ok(());
            };
            self.version = Some(version);
            rest = &rest[GREETING_BYTES..];
        }
        while let Some((message, length)) = message(rest)? {
            take(message);
            rest = &rest[length..];
        }
        let used = self.bytes.len() - rest.len();
        self.bytes.drain(..used);
        Ok(())
    }
}

/// Returns the version of the server; `None` until all bytes of the greeting are there.
fn greeting(bytes: &[u8]) -> Result<Option<String>, Error> {
    let start = &bytes[..bytes.len().min(GREETING_BYTES)];
    let known = start.len().min(GREETING_START.len());
    if start[..known] != GREETING_START[..known] {
        let start = start.escape_ascii().to_string();
        return Err(Error::Greeting { start });
    }
    if start.len() < GREETING_BYTES {
        return Ok(None);
    }
    let version = &start[GREETING_START.len()..];
    let end = version
        .iter()
        .position(|byte| *byte == 0)
        .unwrap_or(version.len());
    let version = version[..end].escape_ascii().to_string();
    if version.split('.').next() != Some("3") {
        return Err(Error::Version { version });
    }
    Ok(Some(version))
}

/// Returns the first message and its length; `None` until all its bytes are there.
fn message(bytes: &[u8]) -> Result<Option<(Message, usize)>, Error> {
    let Some((header, rest)) = bytes.split_first_chunk::<HEADER>() else {
        return Ok(None);
    };
    let number = |index: usize| u32::read(&header[4 * index..4 * index + 4]);
    let narrow =
        |what: &'static str, value: u32| u16::try_from(value).map_err(|_| Error::Header { what, value });
    let (interface, index) = (narrow("interface", number(2))?, narrow("index", number(3))?);
    let (kind, subtype, size) = (number(4), number(5), number(9));
    let what = "a message of type";
    let kind = Kind::from_code(kind).ok_or(Error::Header { what, value: kind })?;
    let what = "a message of subtype";
    let subtype = u8::try_from(subtype).map_err(|_| Error::Header { what, value: subtype })?;
    if size as usize > MAX_BODY {
        let what = "a message of length";
        return Err(Error::Header { what, value: size });
    }
    let Some(body) = rest.get(..size as usize) else {
        return Ok(None);
    };
    let message = Message {
        device: Interface(interface).at(index),
        kind,
        subtype,
        stamp: f64::read(&header[24..32]),
        body: body.to_vec(),
    };
    Ok(Some((message, HEADER + body.len())))
}
