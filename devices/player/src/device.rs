//! Devices of a server: an interface and an index, such as `ranger:1`.

use core::fmt;
use core::str::FromStr;

/// A kind of device. The number is Player's code.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Interface(pub u16);

/// A device of a server.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Device {
    /// Its kind.
    pub interface: Interface,
    /// Which of this kind.
    pub index: u16,
}

/// Why a text is no device.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("`{0}` is no device of a Player server: write INTERFACE:INDEX, like ranger:1")]
pub struct DeviceError(String);

/// The interfaces that a session uses, with Player's names.
const NAMES: [(Interface, &str); 8] = [
    (Interface::SERVER, "player"),
    (Interface::POWER, "power"),
    (Interface::BASE, "position2d"),
    (Interface::SONAR, "sonar"),
    (Interface::LASER, "laser"),
    (Interface::HEAD, "ptz"),
    (Interface::BUMPER, "bumper"),
    (Interface::RANGER, "ranger"),
];

impl Interface {
    /// The server itself, `player`.
    pub const SERVER: Self = Self(1);
    /// A battery, `power`.
    pub const POWER: Self = Self(2);
    /// A mobile base, `position2d`.
    pub const BASE: Self = Self(4);
    /// An array of sonars, `sonar`; deprecated in Player for `ranger`.
    pub const SONAR: Self = Self(5);
    /// A laser scanner, `laser`; deprecated in Player for `ranger`.
    pub const LASER: Self = Self(6);
    /// A pan-tilt-zoom unit, `ptz`.
    pub const HEAD: Self = Self(8);
    /// An array of bumpers, `bumper`.
    pub const BUMPER: Self = Self(14);
    /// A laser scanner or an array of range sensors, `ranger`.
    pub const RANGER: Self = Self(62);

    /// Returns a device of this kind.
    #[must_use]
    pub const fn at(self, index: u16) -> Device {
        Device {
            interface: self,
            index,
        }
    }
}

/// Player's name, or the number of an interface that no session uses.
impl fmt::Display for Interface {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match NAMES.iter().find(|(interface, _)| interface == self) {
            Some((_, name)) => f.write_str(name),
            None => write!(f, "interface-{}", self.0),
        }
    }
}

impl fmt::Display for Device {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:{}", self.interface, self.index)
    }
}

impl FromStr for Device {
    type Err = DeviceError;

    fn from_str(text: &str) -> Result<Self, DeviceError> {
        let parsed = text.split_once(':').and_then(|(name, index)| {
            let (interface, _) = NAMES.iter().find(|(_, known)| *known == name)?;
            Some(interface.at(index.parse().ok()?))
        });
        parsed.ok_or_else(|| DeviceError(text.to_owned()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_device_is_written_as_it_is_read() {
        for (interface, name) in NAMES {
            let device = interface.at(3);
            assert_eq!(device.to_string(), format!("{name}:3"));
            assert_eq!(device.to_string().parse(), Ok(device));
        }
        assert_eq!(Interface(31).at(0).to_string(), "interface-31:0");
        for text in ["", "ranger", "ranger:", "ranger:x", "ranger:65536", "radar:0"] {
            let error = text.parse::<Device>().unwrap_err().to_string();
            assert!(error.starts_with(&format!("`{text}`")), "{error}");
        }
    }
}
