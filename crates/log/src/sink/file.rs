//! One file under way: its channels, when it was last flushed, and what is in no chunk yet. The first thing that fails is the
//! last that is tried; counting what was lost is its owner's business.

use std::collections::BTreeMap;
use std::fs::File;
use std::io;
use std::time::{Duration, Instant};

use super::syncer::Syncer;
use super::{Channel, lost_words};
use crate::Origin;
use crate::writer::{Output, Times, Writer};

/// Time between two flushes: half of the second that may be lost.
const FLUSH: Duration = Duration::from_millis(500);

/// A file under way.
pub(crate) struct Begun {
    writer: Writer,
    syncer: Option<Syncer>,
    /// The file's own numbers of channels.
    channels: Vec<u16>,
    flushed: Instant,
    /// Messages since then.
    unflushed: u64,
    kept: u64,
}

impl Begun {
    /// Begins a file; its head has reached the system when this returns. `disk` is asked to have it after each flush.
    pub(crate) fn new(output: Output, disk: Option<File>, origin: &Origin) -> io::Result<Self> {
        let writer = Writer::begin(output, origin)?;
        Ok(Self {
            writer,
            syncer: disk.map(Syncer::start).transpose()?,
            channels: Vec::new(),
            flushed: Instant::now(),
            unflushed: 0,
            kept: 0,
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
        self.unflushed += 1;
        self.writer.message(self.channels[channel], times, data)
    }

    pub(super) fn metadata(&mut self, name: &str, metadata: BTreeMap<String, String>) -> io::Result<()> {
        self.writer.metadata(name, metadata)
    }

    /// Flushes what half a second has brought.
    pub(super) fn flush_in_time(&mut self) -> io::Result<()> {
        if self.flushed.elapsed() < FLUSH {
            return Ok(());
        }
        self.flushed = Instant::now();
        if self.unflushed > 0 {
            self.writer.flush()?;
            self.flushed_all();
        }
        Ok(())
    }

    /// Writes what it lacks, the index and the end.
    pub(super) fn finish(&mut self, lost: &BTreeMap<String, u64>) -> io::Result<()> {
        self.writer.flush()?;
        self.writer.metadata("jde/lost", lost_words(lost))?;
        self.writer.finish()?;
        self.flushed_all();
        Ok(())
    }

    /// Messages that have reached the system.
    pub(super) fn kept(&self) -> u64 {
        self.kept
    }

    /// Messages that have not.
    pub(super) fn unflushed(&self) -> u64 {
        self.unflushed
    }

    /// Bytes that have reached the system.
    pub(super) fn bytes(&self) -> u64 {
        self.writer.bytes()
    }

    fn flushed_all(&mut self) {
        self.kept += std::mem::take(&mut self.unflushed);
        if let Some(syncer) = &self.syncer {
            syncer.ask();
        }
    }
}

/// The file, to ask its disk to have it; a pipe or a device has none.
pub(crate) fn disk(file: &File) -> Option<File> {
    let regular = file.metadata().is_ok_and(|about| about.is_file());
    regular.then(|| file.try_clone().ok()).flatten()
}
