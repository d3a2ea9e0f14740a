//! What a process prints: lines of its schema in the log of the host. Without a log, its output is that of the host.

use std::io::{self, PipeReader, Read};
use std::os::fd::{AsFd, OwnedFd};
use std::process::Command;

use parking_lot::Mutex;
use rustix::event::{PollFd, PollFlags, poll};
use rustix::io::{Errno, ioctl_fionbio};

/// The longest line, bytes; a longer one becomes several.
const MAX_LINE: usize = 4096;
/// How often it reads at once: what a pipe holds. A process that prints faster than anybody reads delays nobody longer.
const MAX_READS: usize = 16;

/// The standard output and error of a process, in one stream.
pub(crate) struct PrintedOutput {
    schema: String,
    stream: Mutex<PrintedStream>,
}

struct PrintedStream<R = PipeReader> {
    pipe: R,
    /// The beginning of a line.
    rest: Vec<u8>,
}

impl PrintedOutput {
    /// Takes the output of the process that `command` will start, if this process has a log.
    ///
    /// # Errors
    /// There is no descriptor left.
    pub(crate) fn capture(command: &mut Command, schema: &str) -> io::Result<Option<Self>> {
        if !tracing::dispatcher::has_been_set() {
            return Ok(None);
        }
        let (pipe, written) = io::pipe()?;
        ioctl_fionbio(&pipe, true)?;
        command.stdout(written.try_clone()?).stderr(written);
        Ok(Some(Self {
            schema: schema.to_owned(),
            stream: Mutex::new(PrintedStream {
                pipe,
                rest: Vec::new(),
            }),
        }))
    }

    /// Logs the lines that have arrived, at most as much as a pipe holds. Returns whether more may come.
    pub(crate) fn forward(&self) -> bool {
        self.stream.lock().forward(&self.schema)
    }

    /// Logs lines until the process with this descriptor has exited, or has closed its output.
    pub(crate) fn forward_until_exit(&self, process: &OwnedFd) {
        let stream = self.stream.lock().pipe.as_fd().try_clone_to_owned();
        let Ok(stream) = stream else {
            return;
        };
        loop {
            let mut watched = [
                PollFd::new(process, PollFlags::IN),
                PollFd::new(&stream, PollFlags::IN),
            ];
            match poll(&mut watched, None) {
                Ok(_) | Err(Errno::INTR) => {}
                Err(_) => return,
            }
            let has_exited = !watched[0].revents().is_empty();
            if !self.forward() || has_exited {
                return;
            }
        }
    }

    /// Logs what is left, also the beginning of a line.
    pub(crate) fn finish(&self) {
        self.forward();
        let mut stream = self.stream.lock();
        let rest = std::mem::take(&mut stream.rest);
        log(&self.schema, &rest);
    }
}

impl<R: Read> PrintedStream<R> {
    fn forward(&mut self, schema: &str) -> bool {
        let mut bytes = [0; MAX_LINE];
        for _ in 0..MAX_READS {
            match self.pipe.read(&mut bytes) {
                Ok(0) => return false,
                Ok(length) => self.log(schema, &bytes[..length]),
                Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
                Err(error) => return error.kind() == io::ErrorKind::WouldBlock,
            }
        }
        true
    }

    fn log(&mut self, schema: &str, bytes: &[u8]) {
        for piece in bytes.split_inclusive(|byte| *byte == b'\n') {
            self.rest.extend_from_slice(piece);
            if self.rest.ends_with(b"\n") || self.rest.len() >= MAX_LINE {
                log(schema, &self.rest);
                self.rest.clear();
            }
        }
    }
}

fn log(schema: &str, line: &[u8]) {
    let line = String::from_utf8_lossy(line);
    let line = line.trim_end();
    if !line.is_empty() {
        // A warning for filters: what somebody prints to see it is shown without an option.
        tracing::warn!(target: "jde::printed", schema, "{line}");
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_flood_without_an_end_is_read_in_pieces() {
        let mut stream = PrintedStream {
            pipe: io::repeat(b'\n'),
            rest: Vec::new(),
        };
        assert!(stream.forward("hog"));
    }
}
