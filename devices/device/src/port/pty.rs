//! A pseudo-terminal: a serial line without a wire, for emulators of devices.

use core::fmt;
use std::ffi::OsStr;
use std::fs::File;
use std::io;
use std::os::fd::OwnedFd;
use std::os::unix::ffi::OsStrExt;
use std::path::{Path, PathBuf};

use rustix::io::{FdFlags, fcntl_getfd, fcntl_setfd};
use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
use rustix::termios::{OptionalActions, tcgetattr, tcsetattr};

/// A serial line without a wire. Bytes written to its master are read at its path, and the other way round.
///
/// Emulators of devices use the master. Programs open the path like any serial line. Dropping it ends the
/// line, as if its plug were pulled.
pub struct Pty {
    master: File,
    path: PathBuf,
}

impl Pty {
    /// Opens a new pseudo-terminal. It is raw from the start, so that it echoes nothing before a program
    /// opens it.
    ///
    /// # Errors
    /// If the system has no pseudo-terminal left.
    pub fn open() -> io::Result<Self> {
        let master: OwnedFd = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY)?;
        fcntl_setfd(&master, fcntl_getfd(&master)? | FdFlags::CLOEXEC)?;
        grantpt(&master)?;
        unlockpt(&master)?;
        let mut settings = tcgetattr(&master)?;
        settings.make_raw();
        tcsetattr(&master, OptionalActions::Now, &settings)?;
        let name = ptsname(&master, Vec::new())?;
        Ok(Self {
            master: File::from(master),
            path: PathBuf::from(OsStr::from_bytes(name.to_bytes())),
        })
    }

    /// Returns the device's end. Reading from it blocks. Reading fails while no program has the path open and
    /// no bytes are left.
    #[must_use]
    pub fn master(&self) -> &File {
        &self.master
    }

    /// Returns the path that programs open.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Returns the speed that was last set at the path, in bits per second.
    ///
    /// # Errors
    /// If the line does not report its speed.
    pub fn baud(&self) -> io::Result<u32> {
        Ok(tcgetattr(&self.master)?.output_speed())
    }
}

impl fmt::Debug for Pty {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Pty({})", self.path.display())
    }
}
