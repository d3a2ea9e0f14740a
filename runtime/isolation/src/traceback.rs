//! The lines of Python in which a process was when it was killed. Its interpreter writes them to memory of the host by
//! `faulthandler`, also when a signal ends it.

use std::fs::File;
use std::io;
use std::os::fd::{AsRawFd, OwnedFd};
use std::os::unix::fs::FileExt;
use std::process::{Command, id};
use std::thread::Builder;

use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::fs::{MemfdFlags, memfd_create};
use rustix::process::{Signal, pidfd_send_signal};

/// The variable that names the file for the lines.
const VARIABLE: &str = "JDE_TRACEBACK";
/// The signal at which the interpreter writes them and ends.
const SIGNAL: Signal = Signal::USR2;
/// How long the interpreter may take for that, ms. It writes a few lines without any lock.
const TIMEOUT_MS: i64 = 200;
/// The most bytes that are read.
const MAX_BYTES: usize = 16_384;
/// The most lines that are shown.
const MAX_LINES: usize = 12;
/// The first file of this package, from the newest call to the oldest: what follows is the same in every process.
const OUTER: &str = "_serve.py\"";

/// The memory that receives the lines.
pub(crate) struct Traceback(File);

impl Traceback {
    /// Gives an interpreter that `command` will start a place for its lines.
    ///
    /// # Errors
    /// There is no memory or descriptor left.
    pub(crate) fn prepare(command: &mut Command) -> io::Result<Self> {
        let file = File::from(memfd_create("traceback", MemfdFlags::CLOEXEC)?);
        command.env(VARIABLE, format!("/proc/{}/fd/{}", id(), file.as_raw_fd()));
        Ok(Self(file))
    }

    /// Returns the lines, from the newest call to the oldest; `None` if the interpreter wrote none.
    pub(crate) fn read(&self) -> Option<String> {
        let mut bytes = vec![0; MAX_BYTES];
        let length = self.0.read_at(&mut bytes, 0).ok()?;
        let text = String::from_utf8_lossy(&bytes[..length]);
        let frames = text.lines().skip_while(|line| !line.starts_with("  File \""));
        let frames = frames.take_while(|line| line.starts_with("  File \"") && !line.contains(OUTER));
        let frames: Vec<_> = frames.take(MAX_LINES).collect();
        (!frames.is_empty()).then(|| frames.join("\n"))
    }
}

/// Ends an interpreter after it has written its lines, or at last without them. Never waits.
pub(crate) fn kill(process: &OwnedFd) {
    let kill = |process: &OwnedFd| {
        // Fails only if the process is dead already.
        let _ = pidfd_send_signal(process, Signal::KILL);
    };
    let asked = pidfd_send_signal(process, SIGNAL);
    let (Ok(()), Ok(watched)) = (asked, process.try_clone()) else {
        return kill(process);
    };
    let wait = move || {
        let timeout = Timespec {
            tv_sec: 0,
            tv_nsec: TIMEOUT_MS * 1_000_000,
        };
        let _ = poll(&mut [PollFd::new(&watched, PollFlags::IN)], Some(&timeout));
        kill(&watched);
    };
    if Builder::new().name("killing".to_owned()).spawn(wait).is_err() {
        kill(process);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_lines_of_a_schema_are_read_without_those_of_the_package() {
        let traceback = Traceback::prepare(&mut Command::new("python3")).expect("memory");
        assert_eq!(traceback.read(), None);
        let text = "Stack (most recent call first):\n  File \"hog.py\", line 12 in deeper\n  File \"hog.py\", line 9 in iterate\n  \
            File \"/lib/jde/_serve.py\", line 33 in main\n  File \"<string>\", line 14 in <module>\n";
        traceback.0.write_all_at(text.as_bytes(), 0).expect("room");
        let expected = "  File \"hog.py\", line 12 in deeper\n  File \"hog.py\", line 9 in iterate";
        assert_eq!(traceback.read().as_deref(), Some(expected));
    }
}
