//! Detects that the terminal has hung up. Code that reads keys through a library must call this module first:
//! the library does not distinguish a hang-up from a silent terminal.

use std::io;
use std::thread;
use std::time::Duration;

use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::io::Errno;

/// The flags that mean that the terminal is gone.
const GONE: PollFlags = PollFlags::HUP.union(PollFlags::ERR).union(PollFlags::NVAL);

/// Waits for a key for at most `timeout`. Returns whether one is available. A signal ends the wait early.
///
/// # Errors
/// The terminal is gone.
pub(super) fn wait_for_key(timeout: Duration) -> io::Result<bool> {
    let stdin = io::stdin();
    let mut descriptors = [PollFd::new(&stdin, PollFlags::IN)];
    let timeout = Timespec {
        tv_sec: timeout.as_secs().try_into().unwrap_or(i64::MAX),
        tv_nsec: timeout.subsec_nanos().into(),
    };
    match poll(&mut descriptors, Some(&timeout)) {
        Ok(_) => {}
        Err(Errno::INTR) => return Ok(false),
        Err(error) => return Err(error.into()),
    }
    let events = descriptors[0].revents();
    if events.intersects(GONE) {
        return Err(io::Error::new(io::ErrorKind::BrokenPipe, "the terminal is gone"));
    }
    Ok(events.contains(PollFlags::IN))
}

/// Calls `action` once the terminal of standard input is gone, on a new thread that ends with the process at
/// the latest.
///
/// # Errors
/// The thread cannot be started.
pub fn on_hang_up(action: impl FnOnce() + Send + 'static) -> io::Result<()> {
    let wait = move || {
        let stdin = io::stdin();
        loop {
            let mut descriptors = [PollFd::new(&stdin, PollFlags::empty())];
            match poll(&mut descriptors, None) {
                Ok(_) if descriptors[0].revents().intersects(GONE) => return action(),
                Ok(_) | Err(Errno::INTR) => {}
                Err(_) => return,
            }
        }
    };
    thread::Builder::new()
        .name("terminal".to_owned())
        .spawn(wait)
        .map(drop)
}
