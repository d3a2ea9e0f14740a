//! Where a device is: the text that a person writes in an application, read and written back. It opens
//! nothing.

use core::fmt;
use core::str::FromStr;

/// Where a device is.
///
/// As text: `tcp:HOST:PORT` (an IPv6 host in brackets), or `serial:PATH@BAUD`, with `,7E1` and the like
/// behind where the line is not 8N1.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Address {
    /// A TCP connection; a serial server counts as one.
    Tcp {
        /// A name or a number; IPv6 without brackets.
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
        /// What a character is on the line.
        framing: Framing,
    },
}

/// What a character is on a serial line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Framing {
    /// 7 or 8.
    pub data_bits: u8,
    /// The bit that checks the others.
    pub parity: Parity,
    /// 1 or 2.
    pub stop_bits: u8,
}

/// The bit that checks the others.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Parity {
    /// There is none.
    None,
    /// The ones are an even number.
    Even,
    /// The ones are an odd number.
    Odd,
}

/// Why a text is no address.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum AddressError {
    /// It begins with neither `tcp:` nor `serial:`.
    #[error(
        "`{0}` is no address of a device: write tcp:HOST:PORT, like tcp:192.168.0.10:10940, \
         or serial:PATH@BAUD, like serial:/dev/ttyUSB0@9600"
    )]
    Kind(String),
    /// Nothing, or nothing good, stands where the host should.
    #[error("`{0}` names no host: write tcp:HOST:PORT, like tcp:192.168.0.10:10940 or tcp:[::1]:10940")]
    Host(String),
    /// What stands last is no port.
    #[error("`{0}` ends in no port: a number from 1 to 65535 follows the host, like tcp:192.168.0.10:10940")]
    Port(String),
    /// Nothing stands where the device file should.
    #[error("`{0}` names no device file: write serial:PATH@BAUD, like serial:/dev/ttyUSB0@9600")]
    Path(String),
    /// What follows the device file is no speed.
    #[error("`{0}` has no speed: bits per second follow the device file, like serial:/dev/ttyUSB0@9600")]
    Baud(String),
    /// What follows the speed is no framing.
    #[error(
        "`{0}` ends in no framing: 7 or 8 data bits, N, E or O for the parity, 1 or 2 stop bits, like 8N1"
    )]
    Framing(String),
}

impl Address {
    /// Reads an address.
    ///
    /// # Errors
    /// If the text is none; in words that say what was expected.
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

    /// Looks whether the device file is there and may be opened by this user, and opens nothing. Of a TCP
    /// connection only a try could tell.
    ///
    /// # Errors
    /// What is missing, and what to do, in words.
    pub fn look(&self) -> Result<(), String> {
        match self {
            Self::Tcp { .. } => Ok(()),
            Self::Serial { path, .. } => crate::serial::look(path),
        }
    }

    /// What its owner calls it in a message: the device file, or host and port.
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
    let bare = match host.strip_prefix('[') {
        Some(inner) => inner.strip_suffix(']').filter(|inner| inner.contains(':')),
        None => Some(host).filter(|host| !host.contains(':')),
    };
    let clean = |host: &&str| {
        !host.is_empty()
            && !host.contains(|c: char| c.is_whitespace() || c.is_control() || "[]@/".contains(c))
    };
    let Some(host) = bare.filter(clean) else {
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

/// Digits alone: Rust's own parsing takes a sign too.
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
    /// 8N1, as nearly every device has it.
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
