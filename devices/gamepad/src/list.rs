//! Which gamepads are there, by what the kernel says of its input devices. Nothing is opened: that could wake a device, and
//! needs a right that the list does not.

use std::fs;
use std::path::{Path, PathBuf};

use crate::layout::{JOYSTICK_BUTTONS, LEFT_STICK, PAD_BUTTONS};

/// A gamepad or joystick that is connected.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Pad {
    /// What it calls itself: the same for all of its kind.
    pub name: String,
    /// Its serial number or radio address; empty if it has none.
    pub serial: String,
    /// Its device file, such as `/dev/input/event5`. The number may be another one when it comes back.
    pub path: PathBuf,
}

/// Lists the gamepads, in the order of their device files. `class` is the kernel's folder `/sys/class/input`; without that
/// folder there are none.
#[must_use]
pub fn pads(class: &Path) -> Vec<Pad> {
    let devices = fs::read_dir(class).into_iter().flatten().flatten();
    let mut numbered: Vec<(u32, Pad)> = devices
        .filter_map(|entry| {
            let file = entry.file_name().into_string().ok()?;
            let number = file.strip_prefix("event")?.parse().ok()?;
            Some((number, pad(&entry.path().join("device"), &file)?))
        })
        .collect();
    numbered.sort_by_key(|(number, _)| *number);
    numbered.into_iter().map(|(_, pad)| pad).collect()
}

/// The device of a folder, if it is a gamepad. The motion sensors and the touchpad of a gamepad are devices of their own.
fn pad(folder: &Path, file: &str) -> Option<Pad> {
    let text = |name| fs::read_to_string(folder.join(name)).unwrap_or_default();
    let keys = text("capabilities/key");
    let axes = text("capabilities/abs");
    let is_pad = LEFT_STICK.iter().all(|code| has_bit(&axes, *code))
        && [PAD_BUTTONS, JOYSTICK_BUTTONS]
            .iter()
            .any(|code| has_bit(&keys, *code));
    is_pad.then(|| Pad {
        name: text("name").trim().to_owned(),
        serial: text("uniq").trim().to_owned(),
        path: Path::new("/dev/input").join(file),
    })
}

/// Whether a bit is set in the kernel's form of a set: hexadecimal words of the machine's size, the lowest one last.
fn has_bit(set: &str, bit: u16) -> bool {
    let word = usize::from(bit) / usize::BITS as usize;
    let word = set.split_whitespace().rev().nth(word);
    let word = word
        .and_then(|word| u64::from_str_radix(word, 16).ok())
        .unwrap_or(0);
    word >> (u32::from(bit) % usize::BITS) & 1 == 1
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    /// The sets of an Xbox pad (driver xpad).
    const XBOX_SETS: (&str, &str) = ("7cdb000000000000 0 0 0 0", "3003f");

    pub(crate) fn add(class: &Path, event: &str, name: &str, serial: &str, (keys, axes): (&str, &str)) {
        let device = class.join(event).join("device");
        fs::create_dir_all(device.join("capabilities")).unwrap();
        let files = [
            ("name", name),
            ("uniq", serial),
            ("capabilities/key", keys),
            ("capabilities/abs", axes),
        ];
        for (file, text) in files {
            fs::write(device.join(file), format!("{text}\n")).unwrap();
        }
    }

    #[test]
    fn gamepads_are_told_from_other_devices() {
        let class = tempfile::tempdir().unwrap();
        let keyboard = ("402000000 3803078f800d001 feffffdfffefffff fffffffffffffffe", "0");
        let mouse = ("1f0000 0 0 0 0", "0");
        let touchpad = ("e520 10000 0 0 0 0", "2608000 3");
        let joystick = ("fff00000000 0 0 0 0", "3f");
        add(class.path(), "event10", "Xbox pad", "", XBOX_SETS);
        add(class.path(), "event2", "stick", "0007", joystick);
        add(class.path(), "event3", "keyboard", "", keyboard);
        add(class.path(), "event4", "mouse", "", mouse);
        add(class.path(), "event5", "touchpad", "", touchpad);
        add(class.path(), "event6", "motion sensors of a pad", "", ("0", "3f"));
        add(class.path(), "event7", "broken", "", ("no bits", "here"));
        add(class.path(), "js0", "Xbox pad", "", XBOX_SETS);
        let found: Vec<_> = pads(class.path())
            .into_iter()
            .map(|pad| (pad.name, pad.serial, pad.path.display().to_string()))
            .collect();
        let expected = [
            ("stick", "0007", "/dev/input/event2"),
            ("Xbox pad", "", "/dev/input/event10"),
        ];
        assert_eq!(
            found,
            expected.map(|(name, serial, path)| (name.to_owned(), serial.to_owned(), path.to_owned()))
        );
    }

    #[test]
    fn without_the_folder_there_are_none() {
        assert_eq!(pads(Path::new("/no/such/folder")), []);
    }
}
