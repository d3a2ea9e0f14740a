//! A recording in parts: when the next part begins, what it begins with, and which old parts are deleted.
//! Each part is a file that can be read alone. Its index ends with it, so the memory in use is limited
//! however long the recording continues.

use std::collections::{BTreeMap, VecDeque};
use std::fs::{self, File, TryLockError};
use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};
use std::time::{SystemTime, UNIX_EPOCH};

use jde_board::Nanos;

use super::file::{ClosedFile, OpenFile};
use super::names::with_disk;
use super::{Effect, SinkChannel};
use crate::part::{self, BEGINS, BYTE, Mark, numbered};
use crate::pre_trigger_buffer::{InForce, StateKey};
use crate::recorder::{self, PartSize, Parts};
use crate::writer::{self, Output, Times};
use crate::{Error, Origin};

use super::syncer::Disk;

/// How late a value may arrive in real time, in ns: one that was published before a part began and arrives
/// within this time is written to the new part. So the values in force at the beginning of a part are stamped
/// this much earlier.
const LATE: Nanos = 100_000_000;

/// The parts of a recording.
pub(crate) struct PartSequence {
    path: PathBuf,
    plan: recorder::SplitOptions,
    origin: Origin,
    overwrite: bool,
    /// In virtual time no value arrives late.
    lossless: bool,
    /// The mark of the present part.
    mark: Mark,
    /// The number of the next file. `None` after the largest number.
    number: Option<u32>,
    /// The handle that holds the lock of the present part. The lock is released when the part ends, although
    /// the disk may need longer.
    lock: Option<File>,
    /// The time at which the present part began, once it has a message.
    began: Option<Nanos>,
    /// The size of the present part before its first new message, in bytes.
    head: u64,
    in_force: InForce<Vec<u8>>,
    /// The numbers of lost values, by topic, that ended parts have reported.
    lost: BTreeMap<String, u64>,
    /// The ended parts of this recording and of earlier ones of this name, the oldest first, with their sizes
    /// in bytes.
    existing: VecDeque<(PathBuf, u64)>,
    parts: Parts,
}

impl PartSequence {
    /// Starts the first part. The numbers of its files follow those of other recordings of this name, so that
    /// the order of the numbers is the order of time. With `overwrite`, existing parts are deleted first.
    ///
    /// # Errors
    /// The first part cannot be written.
    pub(crate) fn begin(
        path: &Path,
        plan: recorder::SplitOptions,
        origin: Origin,
        overwrite: bool,
        lossless: bool,
    ) -> Result<(Self, OpenFile), Error> {
        let failed = |error| Error::Create {
            path: path.to_owned(),
            error,
        };
        let mut before = part::find_parts(path).map_err(failed)?;
        let mut parts = Parts::default();
        if overwrite {
            let mut remaining = Vec::new();
            for (number, path) in before {
                if !remove(&path).map_err(failed)? {
                    parts.undeleted.insert(path.clone());
                    remaining.push((number, path));
                }
            }
            before = remaining;
        }
        let number = before.last().map_or(Some(1), |(number, _)| number.checked_add(1));
        let bytes = |path: &Path| fs::metadata(path).map_or(0, |metadata| metadata.len());
        let since = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
        let mut split = Self {
            path: path.to_owned(),
            plan,
            origin,
            overwrite,
            lossless,
            mark: Mark {
                recording: format!("{:x}-{:x}", since.as_nanos(), std::process::id()),
                number: 0,
            },
            number,
            lock: None,
            began: None,
            head: 0,
            in_force: InForce::default(),
            lost: BTreeMap::new(),
            existing: before
                .into_iter()
                .map(|(_, path)| {
                    let bytes = bytes(&path);
                    (path, bytes)
                })
                .collect(),
            parts,
        };
        let (output, disk) = split.create()?;
        let file = split
            .start_file(output, disk, &[], 0)
            .map_err(|error| Error::Create {
                path: split.parts.last.clone(),
                error,
            })?;
        Ok((split, file))
    }

    /// Returns whether a message of this time starts the next part, when the present part has `bytes` bytes.
    pub(super) fn is_over(&mut self, time: Nanos, bytes: u64) -> bool {
        let began = *self.began.get_or_insert(time);
        match self.plan.part_size {
            PartSize::Bytes(limit) => bytes - self.head >= limit,
            PartSize::Time(limit) => time >= began.saturating_add(limit),
        }
    }

    /// Updates the values in force with a message.
    pub(super) fn update_in_force(&mut self, channel: usize, times: Times, data: &[u8], effect: Effect) {
        match effect {
            Effect::State(StateKey::Stateless) => {}
            Effect::State(about) => {
                let (stored_times, stored_data) = self.in_force.of(channel, about);
                *stored_times = times;
                stored_data.clear();
                stored_data.extend_from_slice(data);
            }
            Effect::Retracts(of) => self.in_force.retract(of),
        }
    }

    /// Returns the number of values lost since the last part ended, given those lost since the beginning.
    pub(super) fn take_lost(&mut self, lost: BTreeMap<String, u64>) -> BTreeMap<String, u64> {
        let before = std::mem::replace(&mut self.lost, lost);
        let since = |(topic, lost): (&String, &u64)| {
            let before = before.get(topic).copied().unwrap_or(0);
            (topic.clone(), lost.saturating_sub(before))
        };
        self.lost.iter().map(since).collect()
    }

    /// Starts the next part at this time, after the present part has ended.
    pub(super) fn next(
        &mut self,
        ended: &ClosedFile,
        channels: &[SinkChannel],
        time: Nanos,
    ) -> io::Result<OpenFile> {
        self.existing.push_back((self.parts.last.clone(), ended.bytes()));
        // Unlocking fails on a file system without locks.
        let _ = self.lock.take().map(|file| file.unlock());
        let (output, disk) = self.create().map_err(|error| match error {
            Error::Create { error, .. } | Error::Thread(error) => error,
            taken @ (Error::Exists(_) | Error::Written(_)) => io::Error::other(taken),
        })?;
        let file = self.start_file(output, disk, channels, time)?;
        self.began = Some(time);
        Ok(file)
    }

    /// Deletes the oldest parts while all parts together, including the `current_bytes` of the present one,
    /// exceed the limit. Parts that another recording is writing are kept.
    pub(super) fn prune(&mut self, current_bytes: u64) -> io::Result<()> {
        let Some(keep) = self.plan.max_total_bytes else {
            return Ok(());
        };
        let mut total = self.existing.iter().map(|(_, bytes)| bytes).sum::<u64>() + current_bytes;
        let mut index = 0;
        while total > keep
            && let Some((oldest, bytes)) = self.existing.get(index)
        {
            let is_deleted = remove(oldest).map_err(|error| {
                let message = format!("cannot delete {}: {error}", oldest.display());
                io::Error::new(error.kind(), message)
            })?;
            if is_deleted {
                total -= bytes;
                self.parts.undeleted.remove(oldest);
                self.parts.deleted += 1;
                self.existing.remove(index);
            } else {
                self.parts.undeleted.insert(oldest.clone());
                index += 1;
            }
        }
        Ok(())
    }

    /// Returns the number of parts, and their paths.
    pub(super) fn parts(&self) -> &Parts {
        &self.parts
    }

    /// Creates the next file whose name is free.
    fn create(&mut self) -> Result<(Output, Option<Disk>), Error> {
        loop {
            let Some(number) = self.number else {
                return Err(Error::Create {
                    path: self.path.clone(),
                    error: io::Error::other(
                        "the last number of a part is in use; move that part to another folder",
                    ),
                });
            };
            let path = numbered(&self.path, number);
            self.number = number.checked_add(1);
            let file = match writer::create(&path, self.overwrite) {
                Err(Error::Exists(_) | Error::Written(_)) => continue,
                result => result?,
            };
            self.lock = file.try_clone().ok();
            self.parts.last = path;
            return with_disk(file, &self.parts.last);
        }
    }

    /// Writes the beginning of a part: its channels, and the values in force.
    fn start_file(
        &mut self,
        output: Output,
        disk: Option<Disk>,
        channels: &[SinkChannel],
        time: Nanos,
    ) -> io::Result<OpenFile> {
        self.mark.number += 1;
        self.parts.count += 1;
        if self.mark.number == 1 {
            self.parts.first = self.parts.last.clone();
        }
        let mut file = OpenFile::new(output, disk, &self.origin, Some(&self.mark))?;
        channels.iter().try_for_each(|channel| file.open(channel))?;
        let log = time.saturating_sub(if self.lossless { 0 } else { LATE });
        for (channel, times, data) in self.in_force.iter() {
            file.repeat(channel, Times { log, ..times }, data)?;
        }
        file.flush()?;
        self.head = file.bytes();
        if self.mark.number > 1 {
            let byte = BTreeMap::from([(BYTE.to_owned(), self.head.to_string())]);
            file.metadata(BEGINS, byte)?;
        }
        Ok(file)
    }
}

/// Deletes a part unless another recording is writing it. Returns whether it no longer exists.
fn remove(path: &Path) -> io::Result<bool> {
    let opened = File::open(path).and_then(|file| match file.try_lock_shared() {
        Err(TryLockError::WouldBlock) => Ok(None),
        // While this lock is held, no recording writes the file. Without locks this cannot
        // be checked.
        Ok(()) | Err(TryLockError::Error(_)) => fs::remove_file(path).map(|()| Some(file)),
    });
    match opened {
        Err(error) if error.kind() == ErrorKind::NotFound => Ok(true),
        removed => removed.map(|file| file.is_some()),
    }
}
