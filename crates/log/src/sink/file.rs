//! One file that is being written: its channels, the time of its last flush, and how many of its messages the
//! system and the disk have. After the first error its owner must not write again. The owner counts what was
//! lost.

use std::collections::BTreeMap;
use std::io;
use std::time::{Duration, Instant};

use super::syncer::{Disk, Syncer};
use super::{Channel, lost_words};
use crate::Origin;
use crate::part::Mark;
use crate::writer::{Output, Times, Writer};

/// The time between two flushes: half of the second that may be lost.
const FLUSH: Duration = Duration::from_millis(500);

/// A file that is being written.
pub(crate) struct Begun {
    writer: Writer,
    /// The numbers of the channels in the file.
    channels: Vec<u16>,
    flushed: Instant,
    messages: Messages,
}

/// A complete file, as far as this process can know: the disk may not have all of it yet.
pub(crate) struct Ended {
    messages: Messages,
    bytes: u64,
}

/// The number of a file's messages, and of those that are safe.
struct Messages {
    syncer: Option<Syncer>,
    given: u64,
    /// The number of messages that have reached the system.
    flushed: u64,
    /// Whether the disk failed to store what had reached the system.
    failed: bool,
}

impl Begun {
    /// Starts a file. When it returns, the header has reached the system. The disk is synchronised after each
    /// flush.
    pub(crate) fn new(
        output: Output,
        disk: Option<Disk>,
        origin: &Origin,
        part: Option<&Mark>,
    ) -> io::Result<Self> {
        let writer = Writer::begin(output, origin, part)?;
        Ok(Self {
            writer,
            channels: Vec::new(),
            flushed: Instant::now(),
            messages: Messages {
                syncer: disk.map(Syncer::start).transpose()?,
                given: 0,
                flushed: 0,
                failed: false,
            },
        })
    }

    pub(super) fn open(&mut self, channel: &Channel) -> io::Result<()> {
        let number = channel.add_to(&mut self.writer)?;
        self.channels.push(number);
        Ok(())
    }

    /// Adds a message to a channel that is open.
    pub(super) fn message(&mut self, channel: usize, times: Times, data: &[u8]) -> io::Result<()> {
        // Counted first, so that it counts as lost if writing fails.
        self.messages.given += 1;
        self.repeat(channel, times, data)
    }

    /// Writes a message that another file contains already. It is not counted.
    pub(super) fn repeat(&mut self, channel: usize, times: Times, data: &[u8]) -> io::Result<()> {
        self.writer.message(self.channels[channel], times, data)
    }

    pub(super) fn metadata(&mut self, name: &str, metadata: BTreeMap<String, String>) -> io::Result<()> {
        self.writer.metadata(name, metadata)
    }

    /// Flushes everything.
    pub(super) fn flush(&mut self) -> io::Result<()> {
        self.flushed = Instant::now();
        self.writer.flush()?;
        self.messages.flushed();
        Ok(())
    }

    /// Flushes if half a second has passed, and reports an error of the disk about earlier flushes.
    pub(super) fn flush_in_time(&mut self) -> io::Result<()> {
        self.messages.check()?;
        if self.flushed.elapsed() < FLUSH {
            return Ok(());
        }
        if self.messages.given > self.messages.flushed {
            return self.flush();
        }
        self.flushed = Instant::now();
        Ok(())
    }

    /// Writes the numbers of lost messages, the index and the end of the file.
    pub(super) fn close(&mut self, lost: &BTreeMap<String, u64>) -> io::Result<()> {
        self.writer.flush()?;
        self.writer.metadata("jde/lost", lost_words(lost))?;
        self.writer.finish()?;
        self.messages.flushed();
        Ok(())
    }

    /// Does the same as [`Self::close`], and waits until the disk has stored the file.
    pub(super) fn finish(&mut self, lost: &BTreeMap<String, u64>) -> io::Result<()> {
        self.close(lost)?;
        self.messages.wait()
    }

    /// Ends the file where it is, and frees the memory of its index.
    pub(super) fn ended(self) -> Ended {
        let mut messages = self.messages;
        if let Some(syncer) = &mut messages.syncer {
            syncer.close();
        }
        Ended {
            messages,
            bytes: self.writer.bytes(),
        }
    }

    /// Returns the number of messages that have reached the system, or after a failure the disk.
    pub(super) fn kept(&self) -> u64 {
        self.messages.kept()
    }

    /// Returns the number of bytes that have reached the system.
    pub(super) fn bytes(&self) -> u64 {
        self.writer.bytes()
    }
}

impl Ended {
    /// Returns the result of the disk for the whole file. `None` if the disk has not finished yet.
    pub(super) fn poll(&mut self) -> Option<io::Result<()>> {
        let is_done = self.messages.syncer.as_ref().is_none_or(Syncer::is_done);
        is_done.then(|| self.messages.check())
    }

    /// Waits for that result.
    pub(super) fn wait(&mut self) -> io::Result<()> {
        self.messages.wait()
    }

    pub(super) fn kept(&self) -> u64 {
        self.messages.kept()
    }

    /// Returns the number of messages that were written and are not safe.
    pub(super) fn unkept(&self) -> u64 {
        self.messages.given - self.messages.kept()
    }

    pub(super) fn bytes(&self) -> u64 {
        self.bytes
    }
}

impl Messages {
    fn flushed(&mut self) {
        self.flushed = self.given;
        if let Some(syncer) = &self.syncer {
            syncer.ask(self.given);
        }
    }

    fn check(&mut self) -> io::Result<()> {
        let checked = self.syncer.as_ref().map_or(Ok(()), Syncer::check);
        self.failed |= checked.is_err();
        checked
    }

    fn wait(&mut self) -> io::Result<()> {
        if let Some(syncer) = &mut self.syncer {
            syncer.wait();
        }
        self.check()
    }

    fn kept(&self) -> u64 {
        match &self.syncer {
            Some(syncer) if self.failed => syncer.safe(),
            Some(_) | None => self.flushed,
        }
    }
}
