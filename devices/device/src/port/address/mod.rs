//! The address of a device: its text in an application, parsed and formatted. It opens nothing.

use core::fmt;
use core::str::FromStr;

/// The address of a device.
///
/// The text is `tcp:HOST:PORT`, with an IPv6 host in brackets, or `serial:PATH@BAUD`, followed by a framing
/// such as `,7E1` if the line is not 8N1.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Address {
    /// A TCP connection, to a serial server as well.
    Tcp {
        /// A host name or an IP address; IPv6 without brackets.
        host: String,
        /// Its port, never 0.
        port: u16,
    },
    /// A serial line.
    Serial {
        /// The device file.
        path: String,
        /// Bits per second.
        baud: u32,
        /// The form of a character on the line.
        framing: Framing,
    },
}

/// The form of a character on a serial line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Framing {
    /// 7 or 8.
    pub data_bits: u8,
    /// The parity bit.
    pub parity: Parity,
    /// 1 or 2.
    pub stop_bits: u8,
}

/// The parity bit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Parity {
    /// No parity bit.
    None,
    /// The number of ones is even.
    Even,
    /// The number of ones is odd.
    Odd,
}

/// Why a text is not an address.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum AddressError {
    /// It begins with neither `tcp:` nor `serial:`.
    #[error(
        "`{0}` is not an address of a device: write tcp:HOST:PORT, like tcp:192.168.0.10:10940, \
         or serial:PATH@BAUD, like serial:/dev/ttyUSB0@9600"
    )]
    Kind(String),
    /// The host is missing or invalid.
    #[error("`{0}` names no host: write tcp:HOST:PORT, like tcp:192.168.0.10:10940 or tcp:[::1]:10940")]
    Host(String),
    /// The port is missing or invalid.
    #[error(
        "`{0}` has no valid port: a number from 1 to 65535 follows the host, like tcp:192.168.0.10:10940"
    )]
    Port(String),
    /// The device file is missing.
    #[error("`{0}` names no device file: write serial:PATH@BAUD, like serial:/dev/ttyUSB0@9600")]
    Path(String),
    /// The speed after the device file is missing or invalid.
    #[error("`{0}` has no speed: bits per second follow the device file, like serial:/dev/ttyUSB0@9600")]
    Baud(String),
    /// The framing after the speed is invalid.
    #[error(
        "`{0}` has no valid framing: 7 or 8 data bits, N, E or O for the parity, 1 or 2 stop bits, like 8N1"
    )]
    Framing(String),
}

impl Address {
    /// Parses an address.
    ///
    /// # Errors
    /// If the text is not an address. The message states what was expected.
    pub fn parse(text: &str) -> Result<Self, AddressError> {
        let text = text.trim();
        if let Some(rest) = text.strip_prefix("tcp:") {
            tcp(text, rest)
        } else if let Some(rest) = text.strip_prefix("serial:") {
            serial(text, rest)
        } else {
            Err(AddressError::Kind(text.to_owned()))
        }
    }

    /// Checks that the device file exists and that this user may open it, without opening it. A TCP address
    /// is not checked: only an attempt to connect could do that.
    ///
    /// # Errors
    /// The reason and a remedy, as text.
    pub fn check_access(&self) -> Result<(), String> {
        match self {
            Self::Tcp { .. } => Ok(()),
            Self::Serial { path, .. } => super::serial::check_device(path),
        }
    }

    /// Returns the name of the device in messages: the device file, or host and port.
    #[must_use]
    pub fn device(&self) -> String {
        match self {
            Self::Tcp { host, port } if host.contains(':') => format!("[{host}]:{port}"),
            Self::Tcp { host, port } => format!("{host}:{port}"),
            Self::Serial { path, .. } => path.clone(),
        }
    }
}

fn tcp(text: &str, rest: &str) -> Result<Address, AddressError> {
    let Some((host, port)) = rest.rsplit_once(':') else {
        return Err(AddressError::Port(text.to_owned()));
    };
    let host = match host.strip_prefix('[') {
        Some(inner) => inner.strip_suffix(']').filter(|inner| inner.contains(':')),
        None => Some(host).filter(|host| !host.contains(':')),
    };
    let is_valid = |host: &&str| {
        !host.is_empty()
            && !host.contains(|c: char| c.is_whitespace() || c.is_control() || "[]@/".contains(c))
    };
    let Some(host) = host.filter(is_valid) else {
        return Err(AddressError::Host(text.to_owned()));
    };
    match number::<u16>(port) {
        Some(port) if port > 0 => Ok(Address::Tcp {
            host: host.to_owned(),
            port,
        }),
        _ => Err(AddressError::Port(text.to_owned())),
    }
}

fn serial(text: &str, rest: &str) -> Result<Address, AddressError> {
    let Some((path, line)) = rest.rsplit_once('@') else {
        return Err(match rest {
            "" => AddressError::Path(text.to_owned()),
            _ => AddressError::Baud(text.to_owned()),
        });
    };
    if path.is_empty() || path.contains(char::is_control) {
        return Err(AddressError::Path(text.to_owned()));
    }
    let (baud, framing) = match line.split_once(',') {
        None => (line, Ok(Framing::default())),
        Some((baud, framing)) => (baud, framing.parse()),
    };
    let baud = number::<u32>(baud)
        .filter(|baud| *baud > 0)
        .ok_or_else(|| AddressError::Baud(text.to_owned()))?;
    Ok(Address::Serial {
        path: path.to_owned(),
        baud,
        framing: framing.map_err(|()| AddressError::Framing(text.to_owned()))?,
    })
}

/// Parses digits only: Rust's own parser also accepts a sign.
fn number<T: FromStr>(text: &str) -> Option<T> {
    text.bytes()
        .all(|byte| byte.is_ascii_digit())
        .then(|| text.parse().ok())?
}

impl FromStr for Address {
    type Err = AddressError;

    fn from_str(text: &str) -> Result<Self, AddressError> {
        Self::parse(text)
    }
}

impl fmt::Display for Address {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Tcp { .. } => write!(f, "tcp:{}", self.device()),
            Self::Serial { path, baud, framing } if *framing == Framing::default() => {
                write!(f, "serial:{path}@{baud}")
            }
            Self::Serial { path, baud, framing } => write!(f, "serial:{path}@{baud},{framing}"),
        }
    }
}

impl Default for Framing {
    /// 8N1, which nearly every device uses.
    fn default() -> Self {
        Self {
            data_bits: 8,
            parity: Parity::None,
            stop_bits: 1,
        }
    }
}

impl FromStr for Framing {
    type Err = ();

    fn from_str(text: &str) -> Result<Self, ()> {
        let [data @ (b'7' | b'8'), parity, stop @ (b'1' | b'2')] = *text.as_bytes() else {
            return Err(());
        };
        Ok(Self {
            data_bits: data - b'0',
            parity: match parity {
                b'N' | b'n' => Parity::None,
                b'E' | b'e' => Parity::Even,
                b'O' | b'o' => Parity::Odd,
                _ => return Err(()),
            },
            stop_bits: stop - b'0',
        })
    }
}

impl fmt::Display for Framing {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let parity = match self.parity {
            Parity::None => 'N',
            Parity::Even => 'E',
            Parity::Odd => 'O',
        };
        write!(f, "{}{parity}{}", self.data_bits, self.stop_bits)
    }
}

#[cfg(test)]
mod tests;
