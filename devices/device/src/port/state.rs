//! The port itself: its states, its output and its input. All transitions are in this file.

use core::time::Duration;
use std::collections::VecDeque;
use std::io::{ErrorKind, Read, Write};
use std::time::Instant;

use rustix::event::{PollFd, PollFlags, Timespec, poll};

use super::address::Address;
use super::backoff::Backoff;
use super::connect::{Attempt, Stream};

/// How long an attempt may take: longer than one host's timeout, so that the attempt's own error comes first.
const MAX_ATTEMPT_TIME: Duration = Duration::from_secs(5);
/// Most bytes that wait to be sent: over a minute's worth at 9600 baud. With more, the device counts as one
/// that does not receive.
const MAX_QUEUED: usize = 64 << 10;
/// Most bytes that one call reads, so that a device that floods the line does not block its owner.
const MAX_READ: usize = 64 << 10;

/// The connection of a port. Its times are those that the owner passed to `poll`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum PortState {
    /// Not opened yet, or closed by its owner. The next poll opens it.
    Idle,
    /// An attempt is in progress.
    Connecting {
        /// The start of the attempt.
        since: Duration,
    },
    /// The connection is open in both directions.
    Connected {
        /// The time at which the connection opened.
        since: Duration,
    },
    /// The connection broke, or an attempt failed.
    Lost {
        /// The reason, which names the device.
        reason: String,
        /// The time of the next attempt.
        retry_at: Duration,
    },
}

/// A byte stream to a device, polled by its owner. No call but [`Self::flush`] ever blocks.
///
/// Its owner calls [`Self::poll`] in every iteration, and reads and writes in between. [`Self::state`] shows
/// a loss at once. Polling reconnects by itself, at longer and longer intervals while no byte arrives.
#[derive(Debug)]
pub struct Port {
    address: Address,
    backoff: Backoff,
    state: PortState,
    stream: Option<Stream>,
    attempt: Option<Attempt>,
    send_queue: VecDeque<u8>,
    /// Attempts since the last byte arrived.
    attempts: u32,
    now: Duration,
}

impl PortState {
    /// Returns whether the connection is open.
    #[must_use]
    pub fn is_connected(&self) -> bool {
        matches!(self, Self::Connected { .. })
    }
}

impl Port {
    /// Creates a port that is not open yet.
    #[must_use]
    pub fn new(address: Address, backoff: Backoff) -> Self {
        Self {
            address,
            backoff,
            state: PortState::Idle,
            stream: None,
            attempt: None,
            send_queue: VecDeque::new(),
            attempts: 0,
            now: Duration::ZERO,
        }
    }

    /// Returns the address of the device.
    #[must_use]
    pub fn address(&self) -> &Address {
        &self.address
    }

    /// Returns the present state of the connection.
    #[must_use]
    pub fn state(&self) -> &PortState {
        &self.state
    }

    /// Returns the number of attempts to connect since the last byte arrived.
    #[must_use]
    pub fn attempts(&self) -> u32 {
        self.attempts
    }

    /// Opens or reopens the connection when it is time, and sends waiting bytes. `now` is the time since any
    /// fixed moment.
    pub fn poll(&mut self, now: Duration) -> &PortState {
        self.now = now;
        match &self.state {
            PortState::Idle => self.start_attempt(),
            PortState::Connecting { since } => {
                let late = now.saturating_sub(*since) > MAX_ATTEMPT_TIME;
                self.poll_attempt(late);
            }
            PortState::Connected { .. } => self.flush_queue(),
            PortState::Lost { retry_at, .. } => {
                if now >= *retry_at {
                    self.start_attempt();
                }
            }
        }
        &self.state
    }

    /// Appends the bytes that have arrived and returns their number, at most about 64 KiB. They may be split
    /// anywhere.
    pub fn read(&mut self, output: &mut Vec<u8>) -> usize {
        let before = output.len();
        let mut buffer = [0; 4096];
        while let Some(stream) = &mut self.stream
            && output.len() - before < MAX_READ
        {
            match stream.read(&mut buffer) {
                Ok(0) => {
                    let end = stream.end_reason();
                    self.disconnect_with(end);
                }
                Ok(count) => {
                    self.attempts = 0;
                    output.extend_from_slice(&buffer[..count]);
                }
                Err(error) if error.kind() == ErrorKind::WouldBlock => break,
                Err(error) if error.kind() == ErrorKind::Interrupted => {}
                Err(error) => {
                    let message = stream.describe_error(&error);
                    self.disconnect_with(&message);
                }
            }
        }
        output.len() - before
    }

    /// Sends bytes, now or as soon as possible. Either all of them are sent, or the connection is lost.
    ///
    /// Returns whether the bytes were accepted. Without a connection they are not.
    pub fn write(&mut self, bytes: &[u8]) -> bool {
        if self.stream.is_none() {
            return false;
        }
        self.send_queue.extend(bytes);
        self.flush_queue();
        if self.send_queue.len() > MAX_QUEUED {
            let message = format!(
                "it does not receive: {} bytes wait to be sent",
                self.send_queue.len()
            );
            self.disconnect_with(&message);
        }
        self.stream.is_some()
    }

    /// Sends waiting bytes, for at most `timeout`. It may block, and is meant for the last bytes before
    /// closing. Returns whether all bytes were sent.
    pub fn flush(&mut self, timeout: Duration) -> bool {
        let start = Instant::now();
        loop {
            self.flush_queue();
            let Some(stream) = &self.stream else {
                return false;
            };
            if self.send_queue.is_empty() {
                return true;
            }
            let Some(remaining) = timeout
                .checked_sub(start.elapsed())
                .filter(|remaining| !remaining.is_zero())
            else {
                return false;
            };
            let remaining = Timespec {
                tv_sec: remaining.as_secs().try_into().unwrap_or(i64::MAX),
                tv_nsec: remaining.subsec_nanos().into(),
            };
            // The next attempt to send detects a broken stream.
            let _ = poll(&mut [PollFd::new(stream, PollFlags::OUT)], Some(&remaining));
        }
    }

    /// Changes the speed of a serial line, until the connection ends, and returns whether the line has that speed. A
    /// TCP connection is unchanged: the serial server keeps its own speed.
    ///
    /// Call it only after the device has answered earlier bytes: bytes in transit leave at the new speed.
    pub fn set_baud(&mut self, baud: u32) -> bool {
        self.stream
            .as_ref()
            .is_none_or(|stream| stream.set_baud(baud).is_ok())
    }

    /// Switches off the signal DTR (data terminal ready), which opening a serial line switches on, until the connection
    /// ends. Lines without modem signals and TCP connections are unchanged.
    pub fn clear_dtr(&mut self) {
        if let Some(stream) = &self.stream {
            stream.clear_dtr();
        }
    }

    /// Breaks the connection for a reason of the owner: the device is silent, or its bytes are not those of
    /// such a device. The port reconnects as after any other loss.
    pub fn disconnect_with(&mut self, reason: &str) {
        let reason = format!("{}: {reason}", self.address.device());
        self.set_lost(reason);
    }

    /// Closes the port and discards waiting bytes. The next poll reopens it.
    pub fn close(&mut self) {
        self.disconnect();
        self.attempts = 0;
        self.state = PortState::Idle;
    }

    fn start_attempt(&mut self) {
        if let Some(old) = &self.attempt
            && !old.is_finished()
        {
            // An unresolvable name can take minutes, with a thread for each attempt: wait for the existing
            // thread.
            let reason = format!("{}: the last attempt has not ended yet", self.address.device());
            self.set_lost(reason);
            return;
        }
        self.attempts = self.attempts.saturating_add(1);
        match Attempt::start(&self.address) {
            Ok(attempt) => {
                self.attempt = Some(attempt);
                self.state = PortState::Connecting { since: self.now };
            }
            Err(reason) => self.set_lost(reason),
        }
    }

    fn poll_attempt(&mut self, late: bool) {
        match self.attempt.as_ref().and_then(Attempt::result) {
            Some(Ok(stream)) => {
                self.attempt = None;
                self.stream = Some(stream);
                self.state = PortState::Connected { since: self.now };
            }
            Some(Err(reason)) => {
                self.attempt = None;
                self.set_lost(reason);
            }
            None if late => {
                self.disconnect_with("no answer in time: is it switched on, and is the address right?")
            }
            None => {}
        }
    }

    fn flush_queue(&mut self) {
        while let Some(stream) = &mut self.stream
            && !self.send_queue.is_empty()
        {
            match stream.write(self.send_queue.as_slices().0) {
                Ok(0) => {
                    let end = stream.end_reason();
                    self.disconnect_with(end);
                }
                Ok(count) => drop(self.send_queue.drain(..count)),
                Err(error) if error.kind() == ErrorKind::WouldBlock => break,
                Err(error) if error.kind() == ErrorKind::Interrupted => {}
                Err(error) => {
                    let message = stream.describe_error(&error);
                    self.disconnect_with(&message);
                }
            }
        }
    }

    fn set_lost(&mut self, reason: String) {
        self.disconnect();
        let retry_at = self.now.saturating_add(self.backoff.delay_after(self.attempts));
        self.state = PortState::Lost { reason, retry_at };
    }

    fn disconnect(&mut self) {
        if let Some(attempt) = &mut self.attempt {
            attempt.abandon();
        }
        self.stream = None;
        self.send_queue.clear();
    }
}
