//! One file around a firing: which messages of the buffer it contains, its metadata, and its lost messages.
//! After a failure of the disk there is no file, and messages are only counted.

use std::collections::BTreeMap;
use std::io;

use jde_board::Nanos;
use jde_conditions::Firing;

use super::{OpenFile, SinkChannel};
use crate::Origin;
use crate::pre_trigger_buffer::{BufferedMessage, Content, PreTriggerBuffer};
use crate::recorder::TriggeredFile;
use crate::writer::Times;

/// The largest number of firings in a file's metadata. Its events contain all of them.
const MAX_FIRINGS: u32 = 20;

/// A file that is being written, or the counts of one that the disk did not accept.
pub(super) struct CurrentFile {
    /// `None` once the disk accepts no more.
    pub(super) file: Option<OpenFile>,
    /// The number of the next message to write.
    pub(super) next: u64,
    /// No message in the file is older than this.
    start: Nanos,
    /// No message in the file is newer than this.
    pub(super) until: Nanos,
    /// The index of the file in the status.
    pub(super) index: usize,
    lost: BTreeMap<String, u64>,
    /// After a failure of the disk: the messages and bytes that had reached the file, and the messages that
    /// were lost.
    failed_counts: (u64, u64, u64),
    /// How often a condition became true.
    fired: u32,
}

impl CurrentFile {
    pub(super) fn new(next: u64, start: Nanos, until: Nanos, index: usize) -> Self {
        Self {
            file: None,
            next,
            start,
            until,
            index,
            lost: BTreeMap::new(),
            failed_counts: (0, 0, 0),
            fired: 0,
        }
    }

    /// Writes the beginning of the file: the firing, the channels, and the values in force.
    pub(super) fn begin(
        &mut self,
        file: OpenFile,
        origin: &Origin,
        firing: &Firing,
        condition: &str,
        channels: &[SinkChannel],
        buffer: &PreTriggerBuffer,
    ) -> io::Result<()> {
        self.file = Some(file);
        self.record_firing(origin, firing, condition)?;
        channels.iter().try_for_each(|channel| self.open(channel))?;
        let Some(file) = &mut self.file else {
            return Ok(());
        };
        for (channel, times, data) in buffer.base() {
            let log = self.start;
            file.write_message(channel, Times { log, ..times }, data)?;
        }
        Ok(())
    }

    /// Writes metadata about the firing that started or prolongs the file.
    pub(super) fn record_firing(
        &mut self,
        origin: &Origin,
        firing: &Firing,
        condition: &str,
    ) -> io::Result<()> {
        self.fired += 1;
        let name = match self.fired {
            1 => "jde/trigger".to_owned(),
            more => format!("jde/trigger/{more}"),
        };
        let seconds = |time: Nanos| format!("{}.{:09}", time / 1_000_000_000, time % 1_000_000_000);
        let wall = origin.start().saturating_add(firing.time);
        let metadata = BTreeMap::from([
            ("condition".to_owned(), condition.to_owned()),
            ("reason".to_owned(), firing.text.clone()),
            ("time_s".to_owned(), seconds(firing.time)),
            ("time_ns".to_owned(), wall.to_string()),
            ("from_s".to_owned(), seconds(self.start)),
        ]);
        match &mut self.file {
            Some(file) if self.fired <= MAX_FIRINGS => file.metadata(&name, metadata),
            Some(_) | None => Ok(()),
        }
    }

    pub(super) fn open(&mut self, channel: &SinkChannel) -> io::Result<()> {
        match &mut self.file {
            Some(file) => file.open(channel),
            None => Ok(()),
        }
    }

    /// Writes the next message.
    pub(super) fn write_entry(
        &mut self,
        entry: &BufferedMessage,
        channels: &[SinkChannel],
    ) -> io::Result<()> {
        self.next += 1;
        let topic = channels[entry.channel].name();
        match (&entry.content, &mut self.file) {
            (Content::Lost(count), _) => self.add_lost(topic, *count),
            (_, None) => self.add_lost(topic, 1),
            (Content::Message { data, .. } | Content::Retracted { data, .. }, Some(file)) => {
                // A late message is stamped with the start of the file.
                let log = entry.times.log.max(self.start);
                let times = Times { log, ..entry.times };
                file.write_message(entry.channel, times, data)?;
            }
        }
        Ok(())
    }

    /// Counts messages of the file's time that it will not contain.
    pub(super) fn add_lost(&mut self, topic: &str, count: u64) {
        match self.lost.get_mut(topic) {
            Some(lost) => *lost += count,
            None => drop(self.lost.insert(topic.to_owned(), count)),
        }
    }

    pub(super) fn flush_if_due(&mut self) -> io::Result<()> {
        self.file.as_mut().map_or(Ok(()), OpenFile::flush_if_due)
    }

    pub(super) fn finish(&mut self) -> io::Result<()> {
        let Some(file) = &mut self.file else {
            return Ok(());
        };
        file.finish(&self.lost)
    }

    /// Ends the file where it is. Returns the number of messages that were written to it and are not safe.
    pub(super) fn abandon(&mut self) -> u64 {
        let Some(file) = self.file.take() else {
            return 0;
        };
        let mut ended = file.into_closed();
        // The error is known already. This determines how much of the file the disk has stored.
        let _ = ended.wait();
        self.failed_counts = (ended.written(), ended.bytes(), ended.unwritten());
        ended.unwritten()
    }

    /// Updates the status of the file.
    pub(super) fn update_status(&self, written: &mut TriggeredFile) {
        let (kept, bytes, unwritten) = match &self.file {
            Some(file) => (file.written(), file.bytes(), 0),
            None => self.failed_counts,
        };
        (written.written, written.bytes) = (kept, bytes);
        written.lost = unwritten + self.lost.values().sum::<u64>();
    }
}
