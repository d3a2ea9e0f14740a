//! A pseudo-terminal: a serial line without a wire, for whoever plays the device.

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

/// A serial line without a wire. What is written to its master is read at its path, and the other way round.
///
/// Emulators of devices sit at the master; programs open the path like any serial line. Dropped, the line is
/// gone, like one whose plug was pulled.
pub struct Pty {
    master: File,
    path: PathBuf,
}

impl Pty {
    /// A new one, raw from the start, so that nothing is echoed before somebody opens it.
    ///
    /// # Errors
    /// If the system has none left.
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

    /// The device's end; reading from it blocks. Reading fails while nobody has the path open and nothing is
    /// left to read.
    #[must_use]
    pub fn master(&self) -> &File {
        &self.master
    }

    /// Where programs open it.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The speed that was last set at the path, bits per second.
    ///
    /// # Errors
    /// If the line does not tell.
    pub fn baud(&self) -> io::Result<u32> {
        Ok(tcgetattr(&self.master)?.output_speed())
    }
}

impl fmt::Debug for Pty {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Pty({})", self.path.display())
    }
}
