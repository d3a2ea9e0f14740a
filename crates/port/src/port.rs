//! The port itself: its states, what goes out, what comes in. All its transitions are here.

use core::time::Duration;
use std::collections::VecDeque;
use std::io::{ErrorKind, Read, Write};
use std::time::Instant;

use rustix::event::{PollFd, PollFlags, Timespec, poll};

use crate::address::Address;
use crate::backoff::Backoff;
use crate::connect::{Attempt, Stream};

/// How long an attempt may take: longer than a host that does not answer, so that its own words come first.
const LONGEST_ATTEMPT: Duration = Duration::from_secs(5);
/// Most bytes that wait to be sent: at 9600 baud over a minute's worth, so who has more has a device that
/// does not listen.
const MOST_WAITING: usize = 64 << 10;
/// Most bytes that one call reads, so that a device that floods does not keep its owner from anything else.
const MOST_AT_ONCE: usize = 64 << 10;

/// How a port is connected. Times are those its owner gave.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Link {
    /// Not opened yet, or closed by its owner: the next poll opens it.
    Idle,
    /// An attempt is under way.
    Connecting {
        /// Since when.
        since: Duration,
    },
    /// Bytes go both ways.
    Connected {
        /// Since when.
        since: Duration,
    },
    /// The connection broke, or an attempt failed.
    Lost {
        /// Why, in words that name the device.
        reason: String,
        /// When the next attempt begins.
        again: Duration,
    },
}

/// A byte stream to a device, polled by its owner. No call but [`Self::flush`] ever blocks.
///
/// Its owner calls [`Self::poll`] in every iteration and reads and writes meanwhile. A loss shows in
/// [`Self::link`] at once; polling goes on and connects again by itself, ever more rarely while nothing is
/// heard.
#[derive(Debug)]
pub struct Port {
    address: Address,
    backoff: Backoff,
    link: Link,
    stream: Option<Stream>,
    attempt: Option<Attempt>,
    waiting: VecDeque<u8>,
    /// Attempts since a byte was last heard.
    attempts: u32,
    now: Duration,
}

impl Link {
    /// Whether bytes go both ways.
    #[must_use]
    pub fn is_connected(&self) -> bool {
        matches!(self, Self::Connected { .. })
    }
}

impl Port {
    /// A port that is not opened yet.
    #[must_use]
    pub fn new(address: Address, backoff: Backoff) -> Self {
        Self {
            address,
            backoff,
            link: Link::Idle,
            stream: None,
            attempt: None,
            waiting: VecDeque::new(),
            attempts: 0,
            now: Duration::ZERO,
        }
    }

    /// Where the device is.
    #[must_use]
    pub fn address(&self) -> &Address {
        &self.address
    }

    /// How it is connected at present.
    #[must_use]
    pub fn link(&self) -> &Link {
        &self.link
    }

    /// Attempts to connect since the device was last heard.
    #[must_use]
    pub fn attempts(&self) -> u32 {
        self.attempts
    }

    /// Opens, connects again when it is time, and sends what waits. `now` is the time since anything, as long
    /// as it is always the same thing.
    pub fn poll(&mut self, now: Duration) -> &Link {
        self.now = now;
        match &self.link {
            Link::Idle => self.begin(),
            Link::Connecting { since } => {
                let late = now.saturating_sub(*since) > LONGEST_ATTEMPT;
                self.connecting(late);
            }
            Link::Connected { .. } => self.send(),
            Link::Lost { again, .. } => {
                if now >= *again {
                    self.begin();
                }
            }
        }
        &self.link
    }

    /// Appends the bytes that have come since, and says how many. They may be cut anywhere.
    pub fn read(&mut self, into: &mut Vec<u8>) -> usize {
        let before = into.len();
        let mut room = [0; 4096];
        while let Some(stream) = &mut self.stream
            && into.len() - before < MOST_AT_ONCE
        {
            match stream.read(&mut room) {
                Ok(0) => {
                    let end = stream.end();
                    self.lose(end);
                }
                Ok(count) => {
                    self.attempts = 0;
                    into.extend_from_slice(&room[..count]);
                }
                Err(error) if error.kind() == ErrorKind::WouldBlock => break,
                Err(error) if error.kind() == ErrorKind::Interrupted => {}
                Err(error) => {
                    let words = stream.in_words(&error);
                    self.lose(&words);
                }
            }
        }
        into.len() - before
    }

    /// Sends bytes, now or as soon as they go. They go whole or the connection is lost: half a frame is never
    /// left out.
    ///
    /// Answers whether they were taken: they are not without a connection.
    pub fn write(&mut self, bytes: &[u8]) -> bool {
        if self.stream.is_none() {
            return false;
        }
        self.waiting.extend(bytes);
        self.send();
        if self.waiting.len() > MOST_WAITING {
            let words = format!("it does not listen: {} bytes wait to be sent", self.waiting.len());
            self.lose(&words);
        }
        self.stream.is_some()
    }

    /// Sends what waits, for at most `timeout`; for the last words before closing. Answers whether all of it
    /// went.
    pub fn flush(&mut self, timeout: Duration) -> bool {
        let start = Instant::now();
        loop {
            self.send();
            let Some(stream) = &self.stream else {
                return false;
            };
            if self.waiting.is_empty() {
                return true;
            }
            let Some(left) = timeout
                .checked_sub(start.elapsed())
                .filter(|left| !left.is_zero())
            else {
                return false;
            };
            let left = Timespec {
                tv_sec: left.as_secs().try_into().unwrap_or(i64::MAX),
                tv_nsec: left.subsec_nanos().into(),
            };
            // A poll that fails shows in the next attempt to send.
            let _ = poll(&mut [PollFd::new(stream, PollFlags::OUT)], Some(&left));
        }
    }

    /// Changes the speed of a serial line, for as long as it is connected; over TCP the serial server keeps
    /// its own.
    ///
    /// What was written before should have been answered: bytes still on their way leave at the new speed.
    pub fn set_baud(&mut self, baud: u32) {
        if let Some(stream) = &self.stream
            && let Err(error) = stream.set_baud(baud)
        {
            self.lose(&format!("it cannot go at {baud} baud: {error}"));
        }
    }

    /// Breaks off because the owner will not go on: the device is silent, or says what no such device would.
    /// It is tried again as after any other loss.
    pub fn lose(&mut self, reason: &str) {
        let reason = format!("{}: {reason}", self.address.device());
        self.lost(reason);
    }

    /// Closes it. What waits to be sent is forgotten; the next poll opens it anew.
    pub fn close(&mut self) {
        self.disconnect();
        self.attempts = 0;
        self.link = Link::Idle;
    }

    fn begin(&mut self) {
        if let Some(old) = &self.attempt
            && !old.is_over()
        {
            // A name that nobody resolves can take minutes, and a thread each time: wait for the one there
            // is.
            let reason = format!("{}: still no answer from the last attempt", self.address.device());
            self.lost(reason);
            return;
        }
        self.attempts = self.attempts.saturating_add(1);
        match Attempt::start(&self.address) {
            Ok(attempt) => {
                self.attempt = Some(attempt);
                self.link = Link::Connecting { since: self.now };
            }
            Err(reason) => self.lost(reason),
        }
    }

    fn connecting(&mut self, late: bool) {
        match self.attempt.as_ref().and_then(Attempt::result) {
            Some(Ok(stream)) => {
                self.attempt = None;
                self.stream = Some(stream);
                self.link = Link::Connected { since: self.now };
            }
            Some(Err(reason)) => {
                self.attempt = None;
                self.lost(reason);
            }
            None if late => self.lose("no answer in time: is it switched on, and is the address right?"),
            None => {}
        }
    }

    fn send(&mut self) {
        while let Some(stream) = &mut self.stream
            && !self.waiting.is_empty()
        {
            match stream.write(self.waiting.as_slices().0) {
                Ok(0) => {
                    let end = stream.end();
                    self.lose(end);
                }
                Ok(count) => drop(self.waiting.drain(..count)),
                Err(error) if error.kind() == ErrorKind::WouldBlock => break,
                Err(error) if error.kind() == ErrorKind::Interrupted => {}
                Err(error) => {
                    let words = stream.in_words(&error);
                    self.lose(&words);
                }
            }
        }
    }

    fn lost(&mut self, reason: String) {
        self.disconnect();
        let again = self.now.saturating_add(self.backoff.after(self.attempts));
        self.link = Link::Lost { reason, again };
    }

    fn disconnect(&mut self) {
        if let Some(attempt) = &mut self.attempt {
            attempt.abandon();
        }
        self.stream = None;
        self.waiting.clear();
    }
}
