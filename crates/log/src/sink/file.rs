//! One file under way: its channels, when it was last flushed, and what of it the system and the disk have. The first thing that
//! fails is the last that is tried; counting what was lost is its owner's business.

use std::collections::BTreeMap;
use std::io;
use std::time::{Duration, Instant};

use super::syncer::{Disk, Syncer};
use super::{Channel, lost_words};
use crate::Origin;
use crate::part::Mark;
use crate::writer::{Output, Times, Writer};

/// Time between two flushes: half of the second that may be lost.
const FLUSH: Duration = Duration::from_millis(500);

/// A file under way.
pub(crate) struct Begun {
    writer: Writer,
    /// The file's own numbers of channels.
    channels: Vec<u16>,
    flushed: Instant,
    messages: Messages,
}

/// A file that is whole, as far as this process can tell: the disk may not have all of it yet.
pub(crate) struct Ended {
    messages: Messages,
    bytes: u64,
}

/// The messages of a file, and where they are.
struct Messages {
    syncer: Option<Syncer>,
    given: u64,
    /// Those that have reached the system.
    flushed: u64,
    /// The disk does not have all of what reached the system.
    failed: bool,
}

impl Begun {
    /// Begins a file; its head has reached the system when this returns. The disk is asked to have it after each flush.
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
        // Counted before: if it fails, it is among those that are lost.
        self.messages.given += 1;
        self.repeat(channel, times, data)
    }

    /// Adds a message that another file has already: it is not counted.
    pub(super) fn repeat(&mut self, channel: usize, times: Times, data: &[u8]) -> io::Result<()> {
        self.writer.message(self.channels[channel], times, data)
    }

    pub(super) fn metadata(&mut self, name: &str, metadata: BTreeMap<String, String>) -> io::Result<()> {
        self.writer.metadata(name, metadata)
    }

    /// Flushes all that there is.
    pub(super) fn flush(&mut self) -> io::Result<()> {
        self.flushed = Instant::now();
        self.writer.flush()?;
        self.messages.flushed();
        Ok(())
    }

    /// Flushes what half a second has brought, and hears what the disk has said of what was flushed before.
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

    /// Writes what it lacks, the index and the end.
    pub(super) fn close(&mut self, lost: &BTreeMap<String, u64>) -> io::Result<()> {
        self.writer.flush()?;
        self.writer.metadata("jde/lost", lost_words(lost))?;
        self.writer.finish()?;
        self.messages.flushed();
        Ok(())
    }

    /// The same, and waits until the disk has it.
    pub(super) fn finish(&mut self, lost: &BTreeMap<String, u64>) -> io::Result<()> {
        self.close(lost)?;
        self.messages.wait()
    }

    /// Lets go of it where it is, and of the memory that its index takes.
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

    /// Messages that have reached the system, and that the disk has not failed to keep.
    pub(super) fn kept(&self) -> u64 {
        self.messages.kept()
    }

    /// Bytes that have reached the system.
    pub(super) fn bytes(&self) -> u64 {
        self.writer.bytes()
    }
}

impl Ended {
    /// What the disk says of all of it; none if it has not said it yet.
    pub(super) fn poll(&mut self) -> Option<io::Result<()>> {
        let is_done = self.messages.syncer.as_ref().is_none_or(Syncer::is_done);
        is_done.then(|| self.messages.check())
    }

    /// Waits for it.
    pub(super) fn wait(&mut self) -> io::Result<()> {
        self.messages.wait()
    }

    pub(super) fn kept(&self) -> u64 {
        self.messages.kept()
    }

    /// Messages that were given and are not kept.
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
