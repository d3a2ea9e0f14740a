//! The process that looks: maps what it is told to and says what is in it, until nobody asks any more.

use std::io;
use std::os::fd::AsFd;
use std::os::unix::net::UnixStream;

use rustix::fs::{Mode, OFlags};
use rustix::process::{DumpableBehavior, Signal, set_dumpable_behavior, set_parent_process_death_signal};

use super::{Answer, Question};
use crate::apart::{Frame, Kind, ServeError, Wire};
use crate::plugin::Loaded;

/// Looks at plugins in this process for the host at standard input, and returns when that asks for no more. To be called first of all
/// in a program of its own, which does nothing else.
///
/// # Errors
/// [`ServeError::NoHost`].
pub fn serve() -> Result<(), ServeError> {
    let mut wire = Wire::new(meet().map_err(ServeError::NoHost)?);
    while let Ok(frame) = wire.receive() {
        let Ok(question) = serde_json::from_slice::<Question>(&frame.bytes) else {
            return Err(ServeError::NoHost(io::ErrorKind::InvalidData.into()));
        };
        let answer = match Loaded::map(&question.copy, &question.path) {
            Ok(loaded) => Answer::Plugin((*loaded.description).clone()),
            Err(error) => Answer::Refused(error.to_string()),
        };
        let done = Frame {
            bytes: serde_json::to_vec(&answer).map_err(|error| ServeError::NoHost(error.into()))?,
            ..Frame::new(Kind::Done)
        };
        wire.send(&done).map_err(ServeError::NoHost)?;
    }
    Ok(())
}

/// The stream to the host. From here on this process ends with it, and leaves nothing behind when it crashes.
fn meet() -> io::Result<UnixStream> {
    set_parent_process_death_signal(Some(Signal::KILL))?;
    set_dumpable_behavior(DumpableBehavior::NotDumpable)?;
    let stream = UnixStream::from(rustix::stdio::stdin().try_clone_to_owned()?);
    // Without a peer there is no host.
    stream.peer_addr()?;
    let nothing = rustix::fs::open("/dev/null", OFlags::RDONLY | OFlags::CLOEXEC, Mode::empty())?;
    rustix::stdio::dup2_stdin(nothing.as_fd())?;
    Ok(stream)
}
