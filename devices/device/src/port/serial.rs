//! A serial line as a file: exclusive to one program, raw, without flow control, never blocking.

use std::fs::File;
use std::io;

use rustix::fs::{Access, FileType, FlockOperation, Mode, OFlags, access, flock, open, stat};
use rustix::io::Errno;
use rustix::termios::{
    ControlModes, OptionalActions, QueueSelector, SpecialCodeIndex, Termios, ioctl_tiocexcl, tcflush,
    tcgetattr, tcsetattr,
};

use super::address::{Framing, Parity};

/// Opens a line. The error is a message for the person who connected the device.
pub(crate) fn open_port(path: &str, baud: u32, framing: Framing) -> Result<File, String> {
    let flags = OFlags::RDWR | OFlags::NOCTTY | OFlags::NONBLOCK | OFlags::CLOEXEC;
    let line = File::from(open(path, flags, Mode::empty()).map_err(|error| describe_error(error, path))?);
    let mut settings = tcgetattr(&line).map_err(|error| describe_error(error, path))?;
    // The lock excludes programs that request locks, and the ioctl excludes the others; neither is enough
    // alone.
    flock(&line, FlockOperation::NonBlockingLockExclusive).map_err(|error| describe_error(error, path))?;
    ioctl_tiocexcl(&line).map_err(|error| describe_error(error, path))?;
    raw(&mut settings, framing);
    apply(&line, settings, baud).map_err(|error| describe_error(error, path))?;
    // Bytes that arrived before the line was opened belong to no session.
    tcflush(&line, QueueSelector::IFlush).map_err(|error| describe_error(error, path))?;
    Ok(line)
}

/// Checks that a line exists and that this user may open it, without opening it: opening raises the modem
/// signals, which restart some devices.
pub(crate) fn check_device(path: &str) -> Result<(), String> {
    let check = || {
        if FileType::from_raw_mode(stat(path)?.st_mode) != FileType::CharacterDevice {
            return Err(Errno::NOTTY);
        }
        access(path, Access::READ_OK | Access::WRITE_OK)
    };
    check().map_err(|error| describe_error(error, path))
}

/// Changes the speed of an open line.
pub(crate) fn set_baud(line: &File, baud: u32) -> io::Result<()> {
    let settings = tcgetattr(line)?;
    Ok(apply(line, settings, baud)?)
}

/// Sets the speed and verifies it: drivers round speeds that their clock cannot divide.
fn apply(line: &File, mut settings: Termios, baud: u32) -> rustix::io::Result<()> {
    settings.set_speed(baud)?;
    tcsetattr(line, OptionalActions::Now, &settings)?;
    let actual = tcgetattr(line)?.output_speed();
    // A receiver samples in the middle of a bit: over ten bits it tolerates about 5 %, half of it for either
    // end.
    if actual.abs_diff(baud) > baud / 40 {
        return Err(Errno::RANGE);
    }
    Ok(())
}

/// Sets raw mode: bytes pass unchanged, and the line adds none.
fn raw(settings: &mut Termios, framing: Framing) {
    settings.make_raw();
    let modes = &mut settings.control_modes;
    modes.remove(
        ControlModes::CSIZE
            | ControlModes::PARENB
            | ControlModes::PARODD
            | ControlModes::CSTOPB
            | ControlModes::CRTSCTS,
    );
    modes.insert(ControlModes::CREAD | ControlModes::CLOCAL);
    modes.insert(match framing.data_bits {
        7 => ControlModes::CS7,
        _ => ControlModes::CS8,
    });
    match framing.parity {
        Parity::None => {}
        Parity::Even => modes.insert(ControlModes::PARENB),
        Parity::Odd => modes.insert(ControlModes::PARENB | ControlModes::PARODD),
    }
    modes.set(ControlModes::CSTOPB, framing.stop_bits == 2);
    // With a minimum of one byte, reading none means that the line is gone. With a minimum of none it would
    // be ambiguous.
    settings.special_codes[SpecialCodeIndex::VMIN] = 1;
    settings.special_codes[SpecialCodeIndex::VTIME] = 0;
}

fn describe_error(error: Errno, path: &str) -> String {
    let message = io::Error::from(error);
    match error {
        Errno::NOENT | Errno::NXIO | Errno::NODEV => {
            format!("{path}: there is no such device: is it plugged in, and is that its name?")
        }
        Errno::ACCESS | Errno::PERM => format!(
            "{path}: Permission denied: add yourself to the group dialout (sudo usermod -aG dialout $USER) \
             and log in again"
        ),
        Errno::BUSY | Errno::WOULDBLOCK => format!("{path}: another program has it open: close that first"),
        Errno::NOTTY | Errno::ISDIR | Errno::INVAL => format!("{path}: this is not a serial line"),
        Errno::RANGE => format!("{path}: the line does not support that speed: choose another"),
        _ => format!("{path}: {message}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::port::Pty;

    #[test]
    fn a_framing_becomes_the_bits_of_the_line() {
        let pty = Pty::open().expect("a pseudo-terminal");
        let mut settings = tcgetattr(pty.master()).expect("it is a terminal");
        let mut bits = |framing: &str| {
            raw(&mut settings, framing.parse().expect("a framing"));
            let modes = settings.control_modes;
            let contains = |mode| modes.contains(mode);
            assert!(contains(ControlModes::CREAD | ControlModes::CLOCAL) && !contains(ControlModes::CRTSCTS));
            (
                modes & ControlModes::CSIZE == ControlModes::CS8,
                contains(ControlModes::PARENB),
                contains(ControlModes::PARODD),
                contains(ControlModes::CSTOPB),
            )
        };
        assert_eq!(bits("7E2"), (false, true, false, true));
        assert_eq!(bits("8O1"), (true, true, true, false));
        assert_eq!(bits("8N1"), (true, false, false, false));
    }

    #[test]
    fn a_line_is_checked_without_opening_it() {
        let pty = Pty::open().expect("a pseudo-terminal");
        assert_eq!(check_device(&pty.path().display().to_string()), Ok(()));
        let missing = check_device("/dev/no-such-line").expect_err("there is none");
        assert!(missing.contains("is it plugged in"), "{missing}");
        let file = tempfile::NamedTempFile::new().expect("a file");
        let path = file.path().display().to_string();
        assert_eq!(
            check_device(&path),
            Err(format!("{path}: this is not a serial line"))
        );
    }

    #[test]
    fn errors_contain_a_remedy() {
        let message = describe_error(Errno::ACCESS, "/dev/ttyUSB0");
        assert!(message.starts_with("/dev/ttyUSB0: Permission denied: add yourself to the group dialout"));
        assert!(describe_error(Errno::RANGE, "/dev/ttyUSB0").contains("choose another"));
        assert!(describe_error(Errno::IO, "/dev/ttyUSB0").contains("error"));
    }
}
