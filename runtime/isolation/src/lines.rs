//! The lines that a process prints. They end when the process does, whoever else holds its stream: a process that it has
//! started may keep it open for ever. Bytes that are no text are replaced, and no line takes more memory than its limit.

use std::fs::File;
use std::io::{self, ErrorKind, Read};
use std::os::fd::{AsFd, OwnedFd};
use std::process::Child;

use rustix::event::{PollFd, PollFlags, poll};
use rustix::io::{ioctl_fionbio, retry_on_intr};
use rustix::process::{Pid, PidfdFlags, pidfd_open};

/// The bytes that are read at once.
const PIECE_BYTES: usize = 1 << 16;

/// The lines of a stream of a child, without their ends.
pub struct Lines {
    stream: File,
    child: OwnedFd,
    has_exited: bool,
    /// The most bytes of a line. A longer one is several lines.
    most: usize,
    /// What is read and not returned, and how much of it has no end of a line.
    pending: Vec<u8>,
    searched: usize,
}

impl Lines {
    /// Reads the lines of this stream of a child, of at most `most` bytes each.
    ///
    /// # Errors
    /// The system refuses a handle of the child.
    pub fn of(child: &Child, stream: impl Into<OwnedFd>, most: usize) -> io::Result<Self> {
        let stream = stream.into();
        // After the child's exit, what it has printed is read, and nothing is waited for.
        ioctl_fionbio(&stream, true)?;
        Ok(Self {
            child: pidfd_open(Pid::from_child(child), PidfdFlags::empty())?,
            stream: stream.into(),
            has_exited: false,
            most,
            pending: Vec::new(),
            searched: 0,
        })
    }

    /// Returns the next line if it is read already.
    fn take(&mut self) -> Option<String> {
        let unsearched = &self.pending[self.searched..];
        let end = unsearched.iter().position(|byte| *byte == b'\n');
        let (line, rest) = match end {
            Some(end) if self.searched + end <= self.most => (self.searched + end, self.searched + end + 1),
            Some(_) => (self.most, self.most),
            None if self.pending.len() > self.most => (self.most, self.most),
            None => {
                self.searched = self.pending.len();
                return None;
            }
        };
        let text = String::from_utf8_lossy(&self.pending[..line]).into_owned();
        self.pending.drain(..rest);
        self.searched = 0;
        Some(text)
    }

    /// Reads more. Returns whether there was something.
    fn read(&mut self) -> bool {
        let mut piece = [0; PIECE_BYTES];
        loop {
            match self.stream.read(&mut piece) {
                Ok(read) => {
                    self.pending.extend_from_slice(&piece[..read]);
                    return read > 0;
                }
                Err(error) if error.kind() == ErrorKind::Interrupted => {}
                Err(error) if error.kind() == ErrorKind::WouldBlock && !self.has_exited => {
                    let mut either = [
                        PollFd::from_borrowed_fd(self.stream.as_fd(), PollFlags::IN),
                        PollFd::from_borrowed_fd(self.child.as_fd(), PollFlags::IN),
                    ];
                    if retry_on_intr(|| poll(&mut either, None)).is_err() {
                        return false;
                    }
                    self.has_exited = !either[1].revents().is_empty();
                }
                Err(_) => return false,
            }
        }
    }
}

impl Iterator for Lines {
    type Item = String;

    fn next(&mut self) -> Option<String> {
        loop {
            if let Some(line) = self.take() {
                return Some(line);
            }
            if !self.read() {
                let rest = std::mem::take(&mut self.pending);
                self.searched = 0;
                return (!rest.is_empty()).then(|| String::from_utf8_lossy(&rest).into_owned());
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use std::process::{Command, Stdio};

    use jde_watchdog::Watchdog;
    use rustix::process::{Signal, kill_process};

    use super::*;

    /// Runs a shell, and returns the lines that it prints.
    fn lines(script: &str, most: usize) -> Vec<String> {
        let mut child = Command::new("sh")
            .args(["-c", script])
            .stdout(Stdio::piped())
            .spawn()
            .expect("a shell");
        let stream = child.stdout.take().expect("its output");
        let lines = Lines::of(&child, stream, most).expect("a handle").collect();
        child.wait().expect("it has exited");
        lines
    }

    #[test]
    fn bytes_that_are_no_text_are_replaced_and_end_nothing() {
        let _watchdog = Watchdog::for_test();
        let printed = lines(r"printf 'caf\351\n\nsecond\nrest'", 100);
        assert_eq!(printed, ["caf\u{fffd}", "", "second", "rest"]);
    }

    #[test]
    fn a_long_line_is_several() {
        let _watchdog = Watchdog::for_test();
        assert_eq!(lines("printf 'abcdefg\nhi\n'", 3), ["abc", "def", "g", "hi"]);
        let printed = lines("head -c 200000 /dev/zero", 60_000);
        let lengths: Vec<_> = printed.iter().map(String::len).collect();
        assert_eq!(lengths, [60_000, 60_000, 60_000, 20_000]);
    }

    #[test]
    fn the_lines_end_with_the_process_whoever_else_holds_its_stream() {
        let _watchdog = Watchdog::for_test();
        let printed = lines("sleep 3600 & echo $!; exit 3", 100);
        let [other] = printed.as_slice() else {
            panic!("{printed:?}");
        };
        let other = Pid::from_raw(other.parse().expect("its number")).expect("above 0");
        kill_process(other, Signal::KILL).expect("it still runs");
    }
}
