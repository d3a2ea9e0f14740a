//! Which of the gamepads is meant. Where several could be, none is: a robot must not obey another person's pad.

use std::path::{Path, PathBuf};

use crate::list::Pad;

/// What a gamepad must be. What is empty may be anything.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Wanted {
    /// Its name.
    pub name: String,
    /// Its serial number or radio address.
    pub serial: String,
    /// A device file, which may be a link of `/dev/input/by-id` or `/dev/input/by-path`.
    pub device: String,
}

impl Wanted {
    /// Returns the one pad that is meant. `target` follows the links of a device file.
    ///
    /// # Errors
    /// If none or several are meant: a text for the operator, which names the pads that are there.
    pub fn choose(&self, pads: &[Pad], target: impl Fn(&Path) -> Option<PathBuf>) -> Result<Pad, String> {
        let device = match &*self.device {
            "" => None,
            file => Some(target(Path::new(file)).ok_or_else(|| {
                format!("{file} is not there: the gamepad is not connected, or it is another one's name")
            })?),
        };
        let is_meant = |pad: &&Pad| {
            (self.name.is_empty() || self.name == pad.name)
                && (self.serial.is_empty() || self.serial.eq_ignore_ascii_case(&pad.serial))
                && device.as_ref().is_none_or(|device| *device == pad.path)
        };
        let meant: Vec<&Pad> = pads.iter().filter(is_meant).collect();
        match *meant {
            [pad] => Ok(pad.clone()),
            [] if pads.is_empty() => Err("no gamepad is connected: plug it in, or switch it on".to_owned()),
            [] => Err(format!(
                "the gamepad {self} is not connected; there is {}",
                listed(pads.iter())
            )),
            [..] => Err(format!(
                "{} gamepads could be meant, so none is taken: {}; state device_name, serial_number or device",
                meant.len(),
                listed(meant.into_iter()),
            )),
        }
    }
}

impl core::fmt::Display for Wanted {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        let parts = [
            ("", &self.name),
            ("with the serial number ", &self.serial),
            ("at ", &self.device),
        ];
        let parts: Vec<_> = parts
            .iter()
            .filter(|(_, text)| !text.is_empty())
            .map(|(word, text)| format!("{word}{text:?}"))
            .collect();
        f.write_str(&parts.join(" "))
    }
}

fn listed<'a>(pads: impl Iterator<Item = &'a Pad>) -> String {
    let texts: Vec<_> = pads
        .map(|pad| match &*pad.serial {
            "" => format!("{:?} at {}", pad.name, pad.path.display()),
            serial => format!("{:?} ({serial}) at {}", pad.name, pad.path.display()),
        })
        .collect();
    texts.join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pad(name: &str, serial: &str, event: u32) -> Pad {
        let path = PathBuf::from(format!("/dev/input/event{event}"));
        Pad {
            name: name.to_owned(),
            serial: serial.to_owned(),
            path,
        }
    }

    fn wanted(name: &str, serial: &str, device: &str) -> Wanted {
        Wanted {
            name: name.to_owned(),
            serial: serial.to_owned(),
            device: device.to_owned(),
        }
    }

    /// The event number of the pad that is taken, or why none is.
    fn chosen(wanted: &Wanted, pads: &[Pad]) -> Result<String, String> {
        let links = |file: &Path| match file.to_str()? {
            "/dev/input/by-id/second" => Some(PathBuf::from("/dev/input/event2")),
            other => other.starts_with("/dev/input/event").then(|| file.to_owned()),
        };
        wanted
            .choose(pads, links)
            .map(|pad| pad.path.display().to_string())
    }

    #[test]
    fn of_two_of_a_kind_none_is_taken_unless_one_is_named() {
        let pads = [pad("Pad", "aa:01", 1), pad("Pad", "aa:02", 2)];
        for wanted in [wanted("", "", ""), wanted("Pad", "", "")] {
            let why = chosen(&wanted, &pads).unwrap_err();
            assert!(
                why.contains("2 gamepads could be meant, so none is taken"),
                "{why}"
            );
            assert!(why.contains("(aa:01) at /dev/input/event1"), "{why}");
        }
        assert_eq!(
            chosen(&wanted("", "AA:02", ""), &pads).unwrap(),
            "/dev/input/event2"
        );
        assert_eq!(
            chosen(&wanted("", "", "/dev/input/by-id/second"), &pads).unwrap(),
            "/dev/input/event2"
        );
        assert_eq!(
            chosen(&wanted("Pad", "aa:01", "/dev/input/event1"), &pads).unwrap(),
            "/dev/input/event1"
        );
    }

    #[test]
    fn another_pad_than_the_named_one_is_never_taken() {
        let pads = [pad("Pad", "aa:01", 1)];
        let why = chosen(&wanted("Pad", "aa:02", ""), &pads).unwrap_err();
        assert!(
            why.contains("the gamepad \"Pad\" with the serial number \"aa:02\" is not connected"),
            "{why}"
        );
        assert!(why.contains("there is \"Pad\" (aa:01)"), "{why}");
        assert!(
            chosen(&wanted("Pa", "", ""), &pads).is_err(),
            "a part of a name is not the name"
        );
        assert!(chosen(&wanted("", "", "/dev/input/by-id/gone"), &pads).is_err());
        assert!(
            chosen(&wanted("Pad", "", "/dev/input/event2"), &pads).is_err(),
            "both must be right"
        );
    }

    #[test]
    fn the_only_pad_needs_no_name() {
        assert_eq!(
            chosen(&Wanted::default(), &[pad("Pad", "", 7)]).unwrap(),
            "/dev/input/event7"
        );
        assert!(
            chosen(&Wanted::default(), &[])
                .unwrap_err()
                .contains("no gamepad is connected")
        );
    }
}
