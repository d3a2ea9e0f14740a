//! A gamepad that is open. It asks the kernel what is held now, so there is no queue that could be late or overflow, and no
//! event that could be missed. It reads only: the pad stays usable for other programs.

use std::io::{self, ErrorKind};
use std::os::unix::fs::{FileTypeExt, MetadataExt};
use std::path::Path;
use std::{fs, fs::File};

use evdev::KeyCode;
use evdev::raw_stream::RawDevice;
use rustix::fs::{Access, access, major};

use crate::layout::{Controls, Layout, Range};
use crate::link::{Found, Source};
use crate::list::{Pad, pads};
use crate::wanted::Wanted;

/// The kernel's number of input devices.
const INPUT_MAJOR: u32 = 13;

/// A device of the kernel.
struct Evdev {
    device: RawDevice,
    layout: Layout,
}

/// Opens the gamepad that is meant. It may block while a device wakes: call it on a thread that may wait.
///
/// # Errors
/// If none or several are meant, or it may not be opened: a text for the operator.
pub fn open(wanted: &Wanted) -> Result<Found, String> {
    let pad = find(wanted)?;
    let source = open_device(&pad.path).map_err(|error| explain(&pad.path, &error))?;
    Ok(Found {
        name: format!("{} at {}", pad.name, pad.path.display()),
        source: Box::new(source),
    })
}

/// Checks that the gamepad that is meant is there and may be opened. It opens nothing.
///
/// # Errors
/// As those of [`open`].
pub fn check(wanted: &Wanted) -> Result<(), String> {
    let pad = find(wanted)?;
    let may = access(&pad.path, Access::READ_OK).map_err(io::Error::from);
    may.map_err(|error| explain(&pad.path, &error))
}

fn find(wanted: &Wanted) -> Result<Pad, String> {
    let pads = pads(Path::new("/sys/class/input"));
    wanted.choose(&pads, |file| fs::canonicalize(file).ok())
}

fn explain(path: &Path, error: &io::Error) -> String {
    let path = path.display();
    if error.kind() == ErrorKind::PermissionDenied {
        return format!(
            "{path}: Permission denied: add yourself to the group input (sudo usermod -aG input $USER) and log in again"
        );
    }
    format!("{path}: {error}")
}

fn open_device(path: &Path) -> io::Result<Evdev> {
    // Opening other files can do harm or block.
    let metadata = fs::metadata(path)?;
    if !metadata.file_type().is_char_device() || major(metadata.rdev()) != INPUT_MAJOR {
        return Err(io::Error::other("this is not an input device"));
    }
    let device = RawDevice::from_fd(File::open(path)?.into())?;
    let keys: Vec<u16> = device
        .supported_keys()
        .into_iter()
        .flat_map(|keys| keys.iter())
        .map(|key| key.0)
        .collect();
    let axes = device.supported_absolute_axes();
    let axes: Vec<u16> = axes
        .into_iter()
        .flat_map(|axes| axes.iter())
        .map(|axis| axis.0)
        .collect();
    Ok(Evdev {
        layout: Layout::new(&keys, &axes),
        device,
    })
}

impl Source for Evdev {
    fn read(&mut self) -> io::Result<Controls> {
        let keys = self.device.get_key_state()?;
        let axes = self.device.get_abs_state()?;
        let range = |code: u16| {
            let axis = axes.get(usize::from(code));
            axis.map_or_else(Range::default, |axis| Range {
                value: axis.value,
                minimum: axis.minimum,
                maximum: axis.maximum,
            })
        };
        Ok(self.layout.controls(|code| keys.contains(KeyCode(code)), range))
    }
}
