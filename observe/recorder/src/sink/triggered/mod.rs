//! Files of the time before and after a condition became true. All messages pass through a buffer. A file
//! contains the messages of the buffer from the oldest one until the time after the last firing ends. So no
//! new message waits while old ones are being written, and the memory in use is limited whatever the disk
//! does.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::Ordering;

use jde_board::Nanos;
use jde_conditions::Firing;
use jde_log::part::numbered;

use super::current_file::CurrentFile;
use super::names::{create, is_taken, probe};
use super::{Disk, Effect, OpenFile, Sink, SinkChannel};
use crate::pre_trigger_buffer::{BufferedMessage, Content, PreTriggerBuffer};
use crate::recorder::{FileEvent, OnFile, TriggeredFile};
use crate::topic::Shared;
use crate::writer::{Output, Times};
use crate::{Error, Origin};

/// Creates a file or overwrites one. Returns it with its disk, if it has one.
type CreateFile = fn(&Path, bool) -> Result<(Output, Option<Disk>), Error>;

/// The bytes of messages that are written before the queues are emptied again.
const BATCH_BYTES: usize = 4 << 20;
/// How late a message may arrive in real time, in ns: one that was published before the end of a file and
/// arrives within this time is still in the file.
const MAX_LATENESS: Nanos = 100_000_000;

/// The names of the files, and how much they contain.
pub(crate) struct Plan {
    /// The name from which files are numbered: `drive.mcap` for `drive-001.mcap`, `drive-002.mcap`.
    pub(crate) path: PathBuf,
    pub(crate) overwrite: bool,
    pub(crate) before: Nanos,
    pub(crate) after: Nanos,
    /// The limit of the buffer, in bytes.
    pub(crate) memory: usize,
}

/// The sink of a recording on conditions.
pub(crate) struct TriggeredSink {
    shared: Arc<Shared>,
    origin: Origin,
    plan: Plan,
    buffer: PreTriggerBuffer,
    channels: Vec<SinkChannel>,
    /// The losses of each channel that the buffer has recorded.
    lost: Vec<u64>,
    /// The number of the next file.
    number: u32,
    current: Option<CurrentFile>,
    create_file: CreateFile,
    on_file: OnFile,
    /// Whether a failure has been reported and no file has been complete since.
    failing: bool,
}

impl TriggeredSink {
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
            buffer: PreTriggerBuffer::new(plan.before, plan.memory),
            plan,
            channels: Vec::new(),
            lost: Vec::new(),
            number: 1,
            current: None,
            create_file: create,
            on_file,
            failing: false,
        })
    }

    fn push(&mut self, entry: BufferedMessage) {
        for (number, channel) in self.buffer.push(entry) {
            if let Some(current) = &mut self.current
                && current.next <= number
            {
                current.next = number + 1;
                current.add_lost(self.channels[channel].name(), 1);
                self.shared.dropped.fetch_add(1, Ordering::Relaxed);
            }
        }
    }

    fn begin(&mut self, firing: &Firing, condition: &str) {
        self.buffer.expire(firing.time, self.buffer.next());
        // Messages are not older than the values that are in force before the first of them.
        let oldest = self.buffer.base().map(|(_, times, _)| times.log).max();
        let start = firing
            .time
            .saturating_sub(self.plan.before)
            .max(oldest.unwrap_or(0));
        let created = self.create();
        let path = numbered(&self.plan.path, self.number);
        let index = {
            let mut files = self.shared.files.lock();
            files.push(TriggeredFile {
                path,
                reason: firing.text.clone(),
                time: firing.time,
                fired: 1,
                ..TriggeredFile::default()
            });
            files.len() - 1
        };
        let mut current = CurrentFile::new(
            self.buffer.first(),
            start,
            firing.time.saturating_add(self.plan.after),
            index,
        );
        let is_created = created.is_ok();
        let result = created
            .map_err(|error| error.to_string())
            .and_then(|(output, disk)| {
                OpenFile::new(output, disk, &self.origin, None)
                    .and_then(|file| {
                        let (channels, buffer) = (&self.channels, &self.buffer);
                        current.begin(file, &self.origin, firing, condition, channels, buffer)
                    })
                    .map_err(|error: io::Error| error.to_string())
            });
        self.current = Some(current);
        match result {
            Ok(()) => {
                self.number += 1;
                self.report(index, FileEvent::Started);
            }
            Err(trouble) => {
                self.handle_failure(&trouble);
                // A file whose beginning could not be written is useless, so the next one takes its name. A
                // file that could not be opened is not ours.
                let path = self.shared.files.lock()[index].path.clone();
                if is_created && fs::symlink_metadata(&path).is_ok_and(|there| there.is_file()) {
                    let _ = fs::remove_file(&path);
                }
            }
        }
    }

    /// Creates the next file whose name is free.
    fn create(&mut self) -> Result<(Output, Option<Disk>), Error> {
        loop {
            match (self.create_file)(&numbered(&self.plan.path, self.number), self.plan.overwrite) {
                Err(error) if is_taken(&error) => self.number += 1,
                result => return result,
            }
        }
    }

    /// Writes the messages of the present file that the buffer has, at most `max_bytes` bytes. Returns
    /// whether there are more.
    fn write_pending(&mut self, max_bytes: usize) -> bool {
        let mut written = 0;
        loop {
            let Some(current) = &mut self.current else {
                return false;
            };
            let Some(entry) = self.buffer.get(current.next) else {
                return false;
            };
            if entry.times.log > current.until {
                self.end_file();
                return false;
            }
            if written >= max_bytes {
                return true;
            }
            written += entry.cost();
            let lost = current.file.is_none() && !matches!(entry.content, Content::Lost(_));
            self.shared.dropped.fetch_add(u64::from(lost), Ordering::Relaxed);
            if let Err(error) = current.write_entry(entry, &self.channels) {
                self.handle_failure(&error.to_string());
            }
        }
    }

    /// Abandons the present file after an error. The buffer continues, and the next firing starts a new
    /// attempt.
    fn handle_failure(&mut self, error: &str) {
        let Some(current) = &mut self.current else {
            return;
        };
        self.shared
            .dropped
            .fetch_add(current.abandon(), Ordering::Relaxed);
        let index = current.index;
        self.shared.files.lock()[index].error = Some(error.to_owned());
        *self.shared.error.lock() = Some(error.to_owned());
        self.update_status();
        if !std::mem::replace(&mut self.failing, true) {
            self.report(index, FileEvent::Failed);
        }
    }

    /// Ends the present file, after the time that follows the last firing.
    fn end_file(&mut self) {
        let Some(current) = &mut self.current else {
            return;
        };
        let index = current.index;
        if current.file.is_some() {
            match current.finish() {
                Ok(()) => {
                    self.failing = false;
                    self.update_status();
                    self.report(index, FileEvent::Ended);
                }
                Err(error) => self.handle_failure(&error.to_string()),
            }
        }
        self.update_status();
        self.current = None;
    }

    /// Updates the status of the files.
    fn update_status(&self) {
        let mut files = self.shared.files.lock();
        if let Some(current) = &self.current {
            current.update_status(&mut files[current.index]);
        }
        let bytes = files.iter().map(|file| file.bytes).sum();
        self.shared.bytes.store(bytes, Ordering::Relaxed);
        let kept = files.iter().map(|file| file.written).sum();
        self.shared.written.store(kept, Ordering::Release);
    }

    fn report(&mut self, index: usize, event: FileEvent) {
        // The lock is released first, because the callback may read the status.
        let file = self.shared.files.lock()[index].clone();
        (self.on_file)(event, &file);
    }

    /// Records in the buffer the messages that were lost before they arrived, so that the file of that time
    /// reports it.
    fn record_losses(&mut self, now: Nanos) {
        for channel in 0..self.channels.len() {
            let SinkChannel::Topic(queue) = &self.channels[channel] else {
                continue;
            };
            let lost = queue.lost.load(Ordering::Relaxed);
            let before = std::mem::replace(&mut self.lost[channel], lost);
            if lost > before {
                let times = Times {
                    log: now,
                    publish: now,
                    sequence: 0,
                };
                self.push(BufferedMessage {
                    channel,
                    times,
                    content: Content::Lost(lost - before),
                });
            }
        }
    }
}

impl Sink for TriggeredSink {
    fn open(&mut self, channel: SinkChannel) {
        if let Some(current) = &mut self.current
            && let Err(error) = current.open(&channel)
        {
            self.handle_failure(&error.to_string());
        }
        self.channels.push(channel);
        self.lost.push(0);
    }

    fn write_message(&mut self, channel: usize, times: Times, data: &[u8], effect: Effect) {
        let data = Arc::from(data);
        let content = match effect {
            Effect::State(about) => Content::Message { about, data },
            Effect::Retracts(of) => Content::Retracted { of, data },
        };
        self.push(BufferedMessage {
            channel,
            times,
            content,
        });
        if self.shared.lossless {
            // Virtual time waits for the disk, so no message is removed from the buffer before it is written.
            self.write_pending(usize::MAX);
        }
    }

    fn fired(&mut self, firing: &Firing, condition: &str) {
        let is_over = |current: &CurrentFile| current.file.is_none() || current.until < firing.time;
        if self.current.as_ref().is_some_and(is_over) {
            self.write_pending(usize::MAX);
            self.end_file();
        }
        let Some(current) = &mut self.current else {
            self.begin(firing, condition);
            // If the memory is full, the oldest messages are removed first, so they are written at once.
            self.write_pending(if self.shared.lossless {
                usize::MAX
            } else {
                BATCH_BYTES
            });
            return;
        };
        let index = current.index;
        current.until = current.until.max(firing.time.saturating_add(self.plan.after));
        self.shared.files.lock()[index].fired += 1;
        if let Err(error) = current.record_firing(&self.origin, firing, condition) {
            self.handle_failure(&error.to_string());
        } else {
            self.report(index, FileEvent::Extended);
        }
    }

    fn poll(&mut self, now: Nanos) -> bool {
        self.record_losses(now);
        let more = self.write_pending(BATCH_BYTES);
        let is_over = |current: &CurrentFile| current.until.saturating_add(MAX_LATENESS) < now;
        let is_over = self.current.as_ref().is_some_and(is_over);
        if is_over && !more {
            self.end_file();
        }
        if let Some(current) = &mut self.current {
            if let Err(error) = current.flush_if_due() {
                self.handle_failure(&error.to_string());
            }
            self.update_status();
        }
        let keep = self
            .current
            .as_ref()
            .map_or(self.buffer.next(), |current| current.next);
        self.buffer.expire(now, keep);
        self.shared
            .evicted
            .store(self.buffer.evicted(), Ordering::Relaxed);
        more
    }

    fn finish(&mut self) {
        self.write_pending(usize::MAX);
        self.end_file();
    }
}

#[cfg(test)]
mod tests;
