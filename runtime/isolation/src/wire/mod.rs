//! The stream between the host and a process of its own: messages over a Unix socket, each behind its length.
//!
//! Messages are encoded by `postcard`, whose readers take from a message no more than it has. It does not limit how deep
//! values nest: whoever sends types or panels does.

use std::io::{self, BufReader, Read, Write};
use std::net::Shutdown;
use std::os::unix::net::UnixStream;
use std::time::Duration;

use serde::{Deserialize, Serialize};

/// The most bytes of a message: the largest value (256 MiB), and what is said of it.
const MAX_BYTES: u64 = (256 << 20) + 1024;
/// The room that is made at once for the bytes of a message, and kept for the next.
const ROOM_STEP: usize = 1 << 20;

/// One end of the stream.
#[derive(Debug)]
pub struct Wire {
    stream: BufReader<UnixStream>,
    /// The messages to be sent.
    output: Vec<u8>,
    /// Begins with the message that was received last.
    input: Vec<u8>,
}

impl Wire {
    /// Wraps one end of a stream.
    pub fn new(stream: UnixStream) -> Self {
        Self {
            stream: BufReader::new(stream),
            output: Vec::new(),
            input: Vec::new(),
        }
    }

    /// Sets how long reads and writes wait for the other end; without a limit if `timeout` is `None`.
    pub fn set_timeout(&self, timeout: Option<Duration>) -> io::Result<()> {
        let stream = self.stream.get_ref();
        stream.set_read_timeout(timeout)?;
        stream.set_write_timeout(timeout)
    }

    /// Shuts the stream down, so that the other end detects its end.
    pub fn close(&self) {
        // Fails only if the other end is gone already.
        drop(self.stream.get_ref().shutdown(Shutdown::Both));
    }

    /// Sends a message, after those in the queue.
    ///
    /// # Errors
    /// Errors of the system.
    pub fn send(&mut self, message: &impl Serialize) -> io::Result<()> {
        self.queue(message);
        self.flush()
    }

    /// Queues a message, to be sent with the next.
    pub fn queue(&mut self, message: &impl Serialize) {
        let start = self.output.len();
        self.output.extend([0; size_of::<u64>()]);
        // A vector takes everything; no message has a sequence without a length, or a path that must be text.
        postcard::to_io(message, &mut self.output).expect("every message can be encoded");
        let (length, encoded) = self.output[start..].split_at_mut(size_of::<u64>());
        length.copy_from_slice(&(encoded.len() as u64).to_ne_bytes());
    }

    /// Sends the queue.
    ///
    /// # Errors
    /// Errors of the system.
    pub fn flush(&mut self) -> io::Result<()> {
        let sent = self.stream.get_mut().write_all(&self.output);
        self.output.clear();
        sent
    }

    /// Receives the next message.
    ///
    /// # Errors
    /// Errors of the system; `UnexpectedEof` if the other end is gone; `InvalidData` if the bytes are no such
    /// message.
    pub fn receive<'a, M: Deserialize<'a>>(&'a mut self) -> io::Result<M> {
        let mut length = [0; size_of::<u64>()];
        self.stream.read_exact(&mut length)?;
        let length @ ..=MAX_BYTES = u64::from_ne_bytes(length) else {
            return Err(io::ErrorKind::InvalidData.into());
        };
        let length = length as usize;
        self.input.truncate(ROOM_STEP);
        self.input.shrink_to(ROOM_STEP);
        let mut end = 0;
        while end < length {
            let start = end;
            end = length.min(start + ROOM_STEP);
            self.input.resize(end.max(self.input.len()), 0);
            self.stream.read_exact(&mut self.input[start..end])?;
        }
        match postcard::take_from_bytes(&self.input[..length]) {
            Ok((message, [])) => Ok(message),
            Ok(_) | Err(_) => Err(io::ErrorKind::InvalidData.into()),
        }
    }
}

#[cfg(test)]
mod tests;
