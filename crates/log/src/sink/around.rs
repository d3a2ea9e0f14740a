//! One file around a firing: which messages of the ring it contains, its metadata, and what it lacks. After a
//! failure of the disk there is no file, and messages are only counted.

use std::collections::BTreeMap;
use std::io;

use jde_board::Nanos;

use super::{Begun, Channel};
use crate::Origin;
use crate::recorder::Written;
use crate::ring::{Content, Entry, Ring};
use crate::trigger::Firing;
use crate::writer::Times;

/// The largest number of firings in a file's metadata. Its events contain all of them.
const TOLD: u32 = 20;

/// A file that is being written, or the counts of one that the disk did not accept.
pub(super) struct Around {
    /// `None` once the disk accepts no more.
    pub(super) file: Option<Begun>,
    /// The number of the next message to write.
    pub(super) next: u64,
    /// No message in the file is older than this.
    start: Nanos,
    /// No message in the file is newer than this.
    pub(super) until: Nanos,
    /// The index of the file in the status.
    pub(super) place: usize,
    lost: BTreeMap<String, u64>,
    /// After a failure of the disk: the messages and bytes that had reached the file, and the messages that
    /// were lost.
    left: (u64, u64, u64),
    /// How often a condition became true.
    fired: u32,
}

impl Around {
    pub(super) fn new(next: u64, start: Nanos, until: Nanos, place: usize) -> Self {
        Self {
            file: None,
            next,
            start,
            until,
            place,
            lost: BTreeMap::new(),
            left: (0, 0, 0),
            fired: 0,
        }
    }

    /// Writes the beginning of the file: the firing, the channels, and the values in force.
    pub(super) fn begin(
        &mut self,
        file: Begun,
        origin: &Origin,
        firing: &Firing,
        condition: &str,
        channels: &[Channel],
        ring: &Ring,
    ) -> io::Result<()> {
        self.file = Some(file);
        self.fired_again(origin, firing, condition)?;
        channels.iter().try_for_each(|channel| self.open(channel))?;
        let Some(file) = &mut self.file else {
            return Ok(());
        };
        for (channel, times, data) in ring.base() {
            let log = self.start;
            file.message(channel, Times { log, ..times }, data)?;
        }
        Ok(())
    }

    /// Writes metadata about the firing that started or prolongs the file.
    pub(super) fn fired_again(
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
        let why = BTreeMap::from([
            ("condition".to_owned(), condition.to_owned()),
            ("reason".to_owned(), firing.text.clone()),
            ("time_s".to_owned(), seconds(firing.time)),
            ("time_ns".to_owned(), wall.to_string()),
            ("from_s".to_owned(), seconds(self.start)),
        ]);
        match &mut self.file {
            Some(file) if self.fired <= TOLD => file.metadata(&name, why),
            Some(_) | None => Ok(()),
        }
    }

    pub(super) fn open(&mut self, channel: &Channel) -> io::Result<()> {
        match &mut self.file {
            Some(file) => file.open(channel),
            None => Ok(()),
        }
    }

    /// Writes the next message.
    pub(super) fn take(&mut self, entry: &Entry, channels: &[Channel]) -> io::Result<()> {
        self.next += 1;
        let topic = channels[entry.channel].name();
        match (&entry.content, &mut self.file) {
            (Content::Lost(count), _) => self.lose(topic, *count),
            (_, None) => self.lose(topic, 1),
            (Content::Message { data, .. } | Content::Retracted { data, .. }, Some(file)) => {
                // A late message is stamped with the start of the file.
                let log = entry.times.log.max(self.start);
                let times = Times { log, ..entry.times };
                file.message(entry.channel, times, data)?;
            }
        }
        Ok(())
    }

    /// Counts messages of the file's time that it will not contain.
    pub(super) fn lose(&mut self, topic: &str, count: u64) {
        match self.lost.get_mut(topic) {
            Some(lost) => *lost += count,
            None => drop(self.lost.insert(topic.to_owned(), count)),
        }
    }

    pub(super) fn flush_in_time(&mut self) -> io::Result<()> {
        self.file.as_mut().map_or(Ok(()), Begun::flush_in_time)
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
        let mut ended = file.ended();
        // The error is known already. This determines how much of the file the disk has stored.
        let _ = ended.wait();
        self.left = (ended.kept(), ended.bytes(), ended.unkept());
        ended.unkept()
    }

    /// Updates the status of the file.
    pub(super) fn note(&self, written: &mut Written) {
        let (kept, bytes, unwritten) = match &self.file {
            Some(file) => (file.kept(), file.bytes(), 0),
            None => self.left,
        };
        (written.kept, written.bytes) = (kept, bytes);
        written.lost = unwritten + self.lost.values().sum::<u64>();
    }
}
