//! Whether the terminal is still there. What reads keys by a library must ask here first: on a terminal that hung up they read for ever.

use std::io;
use std::thread;
use std::time::Duration;

use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::io::Errno;

/// What says that there is no terminal any more.
const GONE: PollFlags = PollFlags::HUP.union(PollFlags::ERR).union(PollFlags::NVAL);

/// Waits for a key at most so long; answers whether there is one.
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

/// Calls `gone` once the terminal of standard input is gone, on a thread that ends with the process at the latest.
///
/// # Errors
/// There is no thread for it.
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
