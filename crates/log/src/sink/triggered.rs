//! Files of the time before and after a condition became true. All messages pass through a ring. A file
//! contains the messages of the ring from the oldest one until the time after the last firing ends. So no new
//! message waits while old ones are being written, and the memory in use is limited whatever the disk does.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::Ordering;

use jde_board::Nanos;

use super::around::Around;
use super::names::{create, numbered, probe};
use super::{Begun, Channel, Disk, Says, Sink};
use crate::lane::{Shared, lock};
use crate::recorder::{Happened, OnFile, Written};
use crate::ring::{Content, Entry, Ring};
use crate::trigger::Firing;
use crate::writer::{Output, Times};
use crate::{Error, Origin};

/// Creates a file or overwrites one. Returns it with its disk, if it has one.
type Make = fn(&Path, bool) -> Result<(Output, Option<Disk>), Error>;

/// The bytes of messages that are written before the queues are emptied again.
const AT_ONCE: usize = 4 << 20;
/// How late a message may arrive in real time, in ns: one that was published before the end of a file and
/// arrives within this time is still in the file.
const LATE: Nanos = 100_000_000;

/// The names of the files, and how much they contain.
pub(crate) struct Plan {
    /// The name from which files are numbered: `drive.mcap` for `drive-001.mcap`, `drive-002.mcap`.
    pub(crate) path: PathBuf,
    pub(crate) overwrite: bool,
    pub(crate) before: Nanos,
    pub(crate) after: Nanos,
    /// The limit of the ring, in bytes.
    pub(crate) memory: usize,
}

/// The sink of a recording on conditions.
pub(crate) struct Triggered {
    shared: Arc<Shared>,
    origin: Origin,
    plan: Plan,
    ring: Ring,
    channels: Vec<Channel>,
    /// The losses of each channel that the ring has recorded.
    lost: Vec<u64>,
    /// The number of the next file.
    number: u32,
    current: Option<Around>,
    make: Make,
    on_file: OnFile,
    /// Whether a failure has been reported and no file has been complete since.
    failing: bool,
}

impl Triggered {
    /// Creates the folder, and checks whether files can be created there.
    ///
    /// # Errors
    /// No file can be created there.
    pub(crate) fn new(
        shared: &Arc<Shared>,
        origin: Origin,
        plan: Plan,
        on_file: OnFile,
    ) -> Result<Self, Error> {
        probe(&plan.path)?;
        Ok(Self {
            shared: Arc::clone(shared),
            origin,
            ring: Ring::new(plan.before, plan.memory),
            plan,
            channels: Vec::new(),
            lost: Vec::new(),
            number: 1,
            current: None,
            make: create,
            on_file,
            failing: false,
        })
    }

    fn push(&mut self, entry: Entry) {
        for (number, channel) in self.ring.push(entry) {
            if let Some(current) = &mut self.current
                && current.next <= number
            {
                current.next = number + 1;
                current.lose(self.channels[channel].name(), 1);
                self.shared.dropped.fetch_add(1, Ordering::Relaxed);
            }
        }
    }

    fn begin(&mut self, firing: &Firing, condition: &str) {
        self.ring.forget(firing.time, self.ring.next());
        // Messages are not older than the values that are in force before the first of them.
        let oldest = self.ring.base().map(|(_, times, _)| times.log).max();
        let start = firing
            .time
            .saturating_sub(self.plan.before)
            .max(oldest.unwrap_or(0));
        let made = self.create();
        let path = numbered(&self.plan.path, self.number);
        let place = {
            let mut files = lock(&self.shared.files);
            files.push(Written {
                path,
                reason: firing.text.clone(),
                time: firing.time,
                fired: 1,
                ..Written::default()
            });
            files.len() - 1
        };
        let mut current = Around::new(
            self.ring.first(),
            start,
            firing.time.saturating_add(self.plan.after),
            place,
        );
        let is_ours = made.is_ok();
        let begun = made
            .map_err(|error| error.to_string())
            .and_then(|(output, disk)| {
                Begun::new(output, disk, &self.origin, None)
                    .and_then(|file| {
                        let (channels, ring) = (&self.channels, &self.ring);
                        current.begin(file, &self.origin, firing, condition, channels, ring)
                    })
                    .map_err(|error: io::Error| error.to_string())
            });
        self.current = Some(current);
        match begun {
            Ok(()) => {
                self.number += 1;
                self.tell(place, Happened::Began);
            }
            Err(trouble) => {
                self.failed(&trouble);
                // A file whose beginning could not be written is useless, so the next one takes its name. A
                // file that could not be opened is not ours.
                let path = lock(&self.shared.files)[place].path.clone();
                if is_ours && fs::symlink_metadata(&path).is_ok_and(|there| there.is_file()) {
                    let _ = fs::remove_file(&path);
                }
            }
        }
    }

    /// Creates the next file whose name is free.
    fn create(&mut self) -> Result<(Output, Option<Disk>), Error> {
        loop {
            let made = (self.make)(&numbered(&self.plan.path, self.number), self.plan.overwrite);
            if !matches!(made, Err(Error::Exists(_) | Error::Written(_))) {
                return made;
            }
            self.number += 1;
        }
    }

    /// Writes the messages of the present file that the ring has, at most `most` bytes. Returns whether there
    /// are more.
    fn catch_up(&mut self, most: usize) -> bool {
        let mut written = 0;
        loop {
            let Some(current) = &mut self.current else {
                return false;
            };
            let Some(entry) = self.ring.get(current.next) else {
                return false;
            };
            if entry.times.log > current.until {
                self.end();
                return false;
            }
            if written >= most {
                return true;
            }
            written += entry.cost();
            let lost = current.file.is_none() && !matches!(entry.content, Content::Lost(_));
            self.shared.dropped.fetch_add(u64::from(lost), Ordering::Relaxed);
            if let Err(error) = current.take(entry, &self.channels) {
                self.failed(&error.to_string());
            }
        }
    }

    /// Abandons the present file after an error. The ring continues, and the next firing starts a new
    /// attempt.
    fn failed(&mut self, trouble: &str) {
        let Some(current) = &mut self.current else {
            return;
        };
        self.shared
            .dropped
            .fetch_add(current.abandon(), Ordering::Relaxed);
        let place = current.place;
        lock(&self.shared.files)[place].trouble = Some(trouble.to_owned());
        *lock(&self.shared.trouble) = Some(trouble.to_owned());
        self.note();
        if !std::mem::replace(&mut self.failing, true) {
            self.tell(place, Happened::Failed);
        }
    }

    /// Ends the present file, after the time that follows the last firing.
    fn end(&mut self) {
        let Some(current) = &mut self.current else {
            return;
        };
        let place = current.place;
        if current.file.is_some() {
            match current.finish() {
                Ok(()) => {
                    self.failing = false;
                    self.note();
                    self.tell(place, Happened::Ended);
                }
                Err(error) => self.failed(&error.to_string()),
            }
        }
        self.note();
        self.current = None;
    }

    /// Updates the status of the files.
    fn note(&self) {
        let mut files = lock(&self.shared.files);
        if let Some(current) = &self.current {
            current.note(&mut files[current.place]);
        }
        let bytes = files.iter().map(|file| file.bytes).sum();
        self.shared.bytes.store(bytes, Ordering::Relaxed);
        let kept = files.iter().map(|file| file.kept).sum();
        self.shared.kept.store(kept, Ordering::Release);
    }

    fn tell(&mut self, place: usize, happened: Happened) {
        // The lock is released first, because the callback may read the status.
        let written = lock(&self.shared.files)[place].clone();
        (self.on_file)(happened, &written);
    }

    /// Records in the ring what was lost before it arrived here, so that the file of that time reports it.
    fn losses(&mut self, now: Nanos) {
        for channel in 0..self.channels.len() {
            let Channel::Lane(lane) = &self.channels[channel] else {
                continue;
            };
            let lost = lane.lost.load(Ordering::Relaxed);
            let before = std::mem::replace(&mut self.lost[channel], lost);
            if lost > before {
                let times = Times {
                    log: now,
                    publish: now,
                    sequence: 0,
                };
                self.push(Entry {
                    channel,
                    times,
                    content: Content::Lost(lost - before),
                });
            }
        }
    }
}

impl Sink for Triggered {
    fn open(&mut self, channel: Channel) {
        if let Some(current) = &mut self.current
            && let Err(error) = current.open(&channel)
        {
            self.failed(&error.to_string());
        }
        self.channels.push(channel);
        self.lost.push(0);
    }

    fn message(&mut self, channel: usize, times: Times, data: &[u8], says: Says) {
        let data = Arc::from(data);
        let content = match says {
            Says::State(about) => Content::Message { about, data },
            Says::Retracts(of) => Content::Retracted { of, data },
        };
        self.push(Entry {
            channel,
            times,
            content,
        });
        if self.shared.lossless {
            // Virtual time waits for the disk, so no message is removed from the ring before it is written.
            self.catch_up(usize::MAX);
        }
    }

    fn fired(&mut self, firing: &Firing, condition: &str) {
        let is_over = |current: &Around| current.file.is_none() || current.until < firing.time;
        if self.current.as_ref().is_some_and(is_over) {
            self.catch_up(usize::MAX);
            self.end();
        }
        let Some(current) = &mut self.current else {
            self.begin(firing, condition);
            // If the memory is full, the oldest messages are removed first, so they are written at once.
            self.catch_up(if self.shared.lossless { usize::MAX } else { AT_ONCE });
            return;
        };
        let place = current.place;
        current.until = current.until.max(firing.time.saturating_add(self.plan.after));
        lock(&self.shared.files)[place].fired += 1;
        if let Err(error) = current.fired_again(&self.origin, firing, condition) {
            self.failed(&error.to_string());
        } else {
            self.tell(place, Happened::FiredAgain);
        }
    }

    fn round(&mut self, now: Nanos) -> bool {
        self.losses(now);
        let more = self.catch_up(AT_ONCE);
        let is_over = |current: &Around| current.until.saturating_add(LATE) < now;
        let is_over = self.current.as_ref().is_some_and(is_over);
        if is_over && !more {
            self.end();
        }
        if let Some(current) = &mut self.current {
            if let Err(error) = current.flush_in_time() {
                self.failed(&error.to_string());
            }
            self.note();
        }
        let keep = self
            .current
            .as_ref()
            .map_or(self.ring.next(), |current| current.next);
        self.ring.forget(now, keep);
        self.shared.short.store(self.ring.short(), Ordering::Relaxed);
        more
    }

    fn finish(&mut self) {
        self.catch_up(usize::MAX);
        self.end();
    }
}

#[cfg(test)]
mod tests;
