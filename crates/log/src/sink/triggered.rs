//! Files of what was before and after a condition came true. Everything goes through a ring; a file is the ring read from its
//! oldest message on, until the time after the last firing is over. So nothing that comes while an old minute is being written
//! waits for it, and what is in memory stays bounded whatever the disk does.

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

/// Makes a file, or writes over one; answers also with what its disk is asked through.
type Make = fn(&Path, bool) -> Result<(Output, Option<Disk>), Error>;

/// Bytes of messages that are written before the queues are emptied again.
const AT_ONCE: usize = 4 << 20;
/// In real time, what was published before the end of a file and comes so much later is still in it, ns.
const LATE: Nanos = 100_000_000;

/// Which files, and how much of what.
pub(crate) struct Plan {
    /// `drive.mcap` stands for `drive-001.mcap`, `drive-002.mcap`.
    pub(crate) path: PathBuf,
    pub(crate) overwrite: bool,
    pub(crate) before: Nanos,
    pub(crate) after: Nanos,
    /// Bytes of the ring.
    pub(crate) memory: usize,
}

/// Files around what conditions told.
pub(crate) struct Triggered {
    shared: Arc<Shared>,
    origin: Origin,
    plan: Plan,
    ring: Ring,
    channels: Vec<Channel>,
    /// Losses of each channel that the ring knows of.
    lost: Vec<u64>,
    /// Number of the next file.
    number: u32,
    current: Option<Around>,
    make: Make,
    on_file: OnFile,
    /// A failure has been told, and no file has been whole since.
    failing: bool,
}

impl Triggered {
    /// Makes the folder, and sees whether files can be made there.
    ///
    /// # Errors
    /// They cannot.
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
        // No message is older than what is in force before the first.
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
                // What could not even be begun is of no use to anybody, and the next one takes its name.
                // What could not be opened is somebody else's.
                let path = lock(&self.shared.files)[place].path.clone();
                if is_ours && fs::symlink_metadata(&path).is_ok_and(|there| there.is_file()) {
                    let _ = fs::remove_file(&path);
                }
            }
        }
    }

    /// The next file whose name is free.
    fn create(&mut self) -> Result<(Output, Option<Disk>), Error> {
        loop {
            let made = (self.make)(&numbered(&self.plan.path, self.number), self.plan.overwrite);
            if !matches!(made, Err(Error::Exists(_) | Error::Written(_))) {
                return made;
            }
            self.number += 1;
        }
    }

    /// Writes what the ring has of the present file, at most so many bytes; answers whether there is more.
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

    /// The present file takes no more. The ring goes on, and the next firing tries again.
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

    /// The time after the last firing is over.
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

    /// Tells others how the files are doing.
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
        // Not under the lock: whoever is told may look at the status.
        let written = lock(&self.shared.files)[place].clone();
        (self.on_file)(happened, &written);
    }

    /// What was lost before it came here goes into the ring, so that a file says so if it was in its time.
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
            // Virtual time waits for the disk, so nothing has to go before it is written.
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
            // The oldest are the first that have to go when memory is full.
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
