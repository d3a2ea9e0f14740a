//! One file that is being written: its channels, the time of its last flush, and how many of its messages the
//! system and the disk have. After the first error its owner must not write again. The owner counts what was
//! lost.

use std::collections::{BTreeMap, VecDeque};
use std::io;
use std::time::{Duration, Instant};

use jde_board::Nanos;
use jde_log::part::Mark;

use super::syncer::{Disk, Syncer};
use super::{SinkChannel, lost_metadata};
use crate::Origin;
use crate::writer::{Output, Times, Writer};

/// The time between two flushes: half of the second that may be lost.
const FLUSH_INTERVAL: Duration = Duration::from_millis(500);
/// The bytes of a chunk, which ends with the message that exceeds them.
const CHUNK_BYTES: usize = 1 << 20;
/// The bytes of a message in a chunk besides its data.
const MESSAGE_HEAD: usize = 31;

/// A file that is being written.
pub(crate) struct OpenFile {
    writer: Writer,
    /// The numbers of the channels in the file.
    channels: Vec<u16>,
    flushed: Instant,
    /// The bytes of the present chunk.
    chunk_bytes: usize,
    messages: MessageCounts,
}

/// A complete file, as far as this process can know: the disk may not have all of it yet.
pub(crate) struct ClosedFile {
    messages: MessageCounts,
    bytes: u64,
}

/// The number of a file's messages, and of those that are safe.
struct MessageCounts {
    syncer: Option<Syncer>,
    submitted: u64,
    /// The log times of the first message and of the newest.
    times: Option<(Nanos, Nanos)>,
    /// The number of messages that have reached the system.
    flushed: u64,
    /// The last flush that the disk has confirmed, and those since: how many messages the file had, and the log time of the
    /// newest.
    flushes: VecDeque<(u64, Nanos)>,
    /// Whether the disk failed to store what had reached the system.
    failed: bool,
}

impl OpenFile {
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
            chunk_bytes: 0,
            messages: MessageCounts {
                syncer: disk.map(Syncer::start).transpose()?,
                submitted: 0,
                times: None,
                flushed: 0,
                flushes: VecDeque::new(),
                failed: false,
            },
        })
    }

    pub(super) fn open(&mut self, channel: &SinkChannel) -> io::Result<()> {
        let number = channel.add_to(&mut self.writer)?;
        self.channels.push(number);
        Ok(())
    }

    /// Adds a message to a channel that is open.
    pub(super) fn write_message(&mut self, channel: usize, times: Times, data: &[u8]) -> io::Result<()> {
        // Counted first, so that it counts as lost if writing fails.
        self.messages.submitted += 1;
        let (first, newest) = self.messages.times.unwrap_or((times.log, times.log));
        self.messages.times = Some((first.min(times.log), newest.max(times.log)));
        self.repeat(channel, times, data)
    }

    /// Writes a message that another file contains already. It is not counted.
    pub(super) fn repeat(&mut self, channel: usize, times: Times, data: &[u8]) -> io::Result<()> {
        self.writer.write_message(self.channels[channel], times, data)?;
        self.chunk_bytes += MESSAGE_HEAD + data.len();
        if self.chunk_bytes > CHUNK_BYTES {
            self.flush()?;
        }
        Ok(())
    }

    pub(super) fn metadata(&mut self, name: &str, metadata: BTreeMap<String, String>) -> io::Result<()> {
        self.writer.metadata(name, metadata)
    }

    /// Flushes everything.
    pub(super) fn flush(&mut self) -> io::Result<()> {
        (self.flushed, self.chunk_bytes) = (Instant::now(), 0);
        self.writer.flush()?;
        self.messages.flushed();
        Ok(())
    }

    /// Flushes if half a second has passed, and reports an error of the disk about earlier flushes.
    pub(super) fn flush_if_due(&mut self) -> io::Result<()> {
        self.messages.check()?;
        if self.flushed.elapsed() < FLUSH_INTERVAL {
            return Ok(());
        }
        if self.messages.submitted > self.messages.flushed {
            return self.flush();
        }
        self.flushed = Instant::now();
        Ok(())
    }

    /// Writes the numbers of lost messages, the index and the end of the file.
    pub(super) fn close(&mut self, lost: &BTreeMap<String, u64>) -> io::Result<()> {
        self.flush()?;
        self.writer.metadata("jde/lost", lost_metadata(lost))?;
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
    pub(super) fn into_closed(self) -> ClosedFile {
        let mut messages = self.messages;
        if let Some(syncer) = &mut messages.syncer {
            syncer.close();
        }
        ClosedFile {
            messages,
            bytes: self.writer.bytes(),
        }
    }

    /// Returns the number of messages that have reached the system, or after a failure the disk.
    pub(super) fn written(&self) -> u64 {
        self.messages.written()
    }

    /// Returns the number of bytes that have reached the system.
    pub(super) fn bytes(&self) -> u64 {
        self.writer.bytes()
    }
}

impl ClosedFile {
    /// Returns the result of the disk for the whole file. `None` if the disk has not finished yet.
    pub(super) fn poll(&mut self) -> Option<io::Result<()>> {
        let is_done = self.messages.syncer.as_ref().is_none_or(Syncer::is_done);
        is_done.then(|| self.messages.check())
    }

    /// Waits for that result.
    pub(super) fn wait(&mut self) -> io::Result<()> {
        self.messages.wait()
    }

    pub(super) fn written(&self) -> u64 {
        self.messages.written()
    }

    /// Returns the number of messages that were written and are not safe.
    pub(super) fn unwritten(&self) -> u64 {
        self.messages.submitted - self.messages.written()
    }

    /// Returns the log times between which messages are missing: that of the last safe message, or of the first if none is
    /// safe, and that of the last. `None` if there were none.
    pub(super) fn missing(&self) -> Option<(Nanos, Nanos)> {
        let (first, newest) = self.messages.times?;
        Some((self.messages.safe_until().unwrap_or(first), newest))
    }

    pub(super) fn bytes(&self) -> u64 {
        self.bytes
    }
}

impl MessageCounts {
    fn flushed(&mut self) {
        self.flushed = self.submitted;
        if let Some((_, newest)) = self.times {
            self.flushes.push_back((self.flushed, newest));
        }
        let synced = self.syncer.as_ref().map_or(self.flushed, Syncer::synced);
        while self
            .flushes
            .get(1)
            .is_some_and(|(messages, _)| *messages <= synced)
        {
            self.flushes.pop_front();
        }
        if let Some(syncer) = &self.syncer {
            syncer.request(self.submitted);
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

    fn written(&self) -> u64 {
        match &self.syncer {
            Some(syncer) if self.failed => syncer.synced(),
            Some(_) | None => self.flushed,
        }
    }
    /// Returns the log time of the newest message that is safe.
    fn safe_until(&self) -> Option<Nanos> {
        let safe = self.written();
        let mut flushes = self.flushes.iter().rev();
        flushes
            .find(|(messages, _)| *messages <= safe)
            .map(|(_, until)| *until)
    }
}
