//! Detects that the terminal has hung up. Code that reads keys through a library must check here first: the
//! library takes a hang-up for a silent terminal.

use std::io;
use std::thread;
use std::time::Duration;

use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::io::Errno;

/// The flags that mean that the terminal is gone.
const GONE: PollFlags = PollFlags::HUP.union(PollFlags::ERR).union(PollFlags::NVAL);

/// Waits for a key for at most `most`. Returns whether one is available. A signal ends the wait early.
///
/// # Errors
/// The terminal is gone.
pub(super) fn wait_for_key(most: Duration) -> io::Result<bool> {
    let stdin = io::stdin();
    let mut looked = [PollFd::new(&stdin, PollFlags::IN)];
    let most = Timespec {
        tv_sec: most.as_secs().try_into().unwrap_or(i64::MAX),
        tv_nsec: most.subsec_nanos().into(),
    };
    match poll(&mut looked, Some(&most)) {
        Ok(_) => {}
        Err(Errno::INTR) => return Ok(false),
        Err(error) => return Err(error.into()),
    }
    let seen = looked[0].revents();
    if seen.intersects(GONE) {
        return Err(io::Error::new(io::ErrorKind::BrokenPipe, "the terminal is gone"));
    }
    Ok(seen.contains(PollFlags::IN))
}

/// Calls `gone` once the terminal of standard input is gone, on a new thread that ends with the process at
/// the latest.
///
/// # Errors
/// The thread cannot be started.
pub(crate) fn on_hang_up(gone: impl FnOnce() + Send + 'static) -> io::Result<()> {
    let wait = move || {
        let stdin = io::stdin();
        loop {
            let mut looked = [PollFd::new(&stdin, PollFlags::empty())];
            match poll(&mut looked, None) {
                Ok(_) if looked[0].revents().intersects(GONE) => return gone(),
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
