//! A recording in parts: when the next part begins, what it begins with, and which old parts are deleted. One that was to be
//! in one file has further parts only where the disk failed.
//! Each part is a file that can be read alone. Its index ends with it, so the memory in use is limited
//! however long the recording continues.

use std::collections::{BTreeMap, VecDeque};
use std::fs::{self, File, TryLockError};
use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

use jde_board::Nanos;
use jde_log::part::{self, BEGINS, BYTE, GAP, Gap, Mark, numbered};

use super::file::OpenFile;
use super::names::{create, is_taken, with_disk};
use super::{Disk, Effect, SinkChannel};
use crate::pre_trigger_buffer::{InForce, StateKey};
use crate::recorder::{self, PartSize, Parts};
use crate::writer::{self, Output, Times};
use crate::{Error, Origin};

/// How late a value may arrive in real time, in ns: one that was published before a part began and arrives
/// within this time is written to the new part. So the values in force at the beginning of a part are stamped
/// this much earlier.
const MAX_LATENESS: Nanos = 100_000_000;

/// The time until it is tried again to delete a part that could not be deleted.
const DELETION_RETRY: Duration = Duration::from_secs(10);
/// The largest number of gaps that are listed.
const MAX_GAPS: usize = 20;
/// Why a part remains that another recording has locked.
const LOCKED: &str = "another recording is writing it";

/// An ended part of this recording, or of an earlier one of this name.
struct OldPart {
    path: PathBuf,
    bytes: u64,
    /// Whether it could not be deleted when that was last tried. Then it does not count: the others are not deleted in its
    /// place.
    remains: bool,
}

/// The parts of a recording.
pub(crate) struct PartSequence {
    path: PathBuf,
    /// `None` of a recording that was to be in one file.
    plan: Option<recorder::SplitOptions>,
    origin: Origin,
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
    /// The ended parts of this recording and of earlier ones of this name, the oldest first.
    existing: VecDeque<OldPart>,
    /// When it is tried again to delete those that remain.
    next_retry: Instant,
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
        // A file that cannot be read keeps its name, and is no part of ours.
        let (mut before, _) = part::find_parts(path).map_err(failed(path))?;
        let mut parts = Parts::default();
        if overwrite {
            before.retain(|(_, path)| match remove(path) {
                Ok(()) => false,
                Err(reason) => {
                    parts.undeleted.insert(path.clone(), reason);
                    true
                }
            });
        }
        let bytes = |path: &Path| fs::metadata(path).map_or(0, |metadata| metadata.len());
        let mut split = Self::new(path, Some(plan), origin, lossless);
        split.number = before.last().map_or(Some(1), |(number, _)| number.checked_add(1));
        split.existing = before
            .into_iter()
            .map(|(_, path)| OldPart {
                bytes: bytes(&path),
                remains: parts.undeleted.contains_key(&path),
                path,
            })
            .collect();
        split.parts = parts;
        let file = split.create(&[], 0, None)?;
        Ok((split, file))
    }

    /// Starts a recording in one file, which goes on in further parts after the disk has failed. With `overwrite`, those in
    /// which an earlier recording in that file went on are deleted. A pipe or a device has no parts.
    ///
    /// # Errors
    /// The file cannot be written.
    pub(crate) fn begin_whole(
        path: &Path,
        origin: Origin,
        overwrite: bool,
        lossless: bool,
    ) -> Result<(Option<Self>, OpenFile), Error> {
        let mark = if overwrite {
            Mark::read(path).ok().flatten()
        } else {
            None
        };
        let earlier = match mark.filter(|mark| mark.is_whole) {
            Some(mark) => part::find_further_parts(path, &mark).unwrap_or_default().0,
            None => Vec::new(),
        };
        let (output, disk) = create(path, overwrite)?;
        if disk.is_none() {
            let file = OpenFile::new(output, None, &origin, None).map_err(failed(path))?;
            return Ok((None, file));
        }
        let (mut whole, file) = Self::of_whole(path, output, disk, origin, lossless)?;
        for part in earlier {
            if let Err(reason) = remove(&part) {
                whole.parts.undeleted.insert(part, reason);
            }
        }
        Ok((Some(whole), file))
    }

    /// Starts a recording in a file that is created, as [`Self::begin_whole`] does.
    pub(crate) fn of_whole(
        path: &Path,
        output: Output,
        disk: Option<Disk>,
        origin: Origin,
        lossless: bool,
    ) -> Result<(Self, OpenFile), Error> {
        let mut whole = Self::new(path, None, origin, lossless);
        (whole.mark.number, whole.mark.is_whole) = (1, true);
        let file = OpenFile::new(output, disk, &whole.origin, Some(&whole.mark)).map_err(failed(path))?;
        whole.parts = Parts {
            first: path.to_owned(),
            last: path.to_owned(),
            count: 1,
            ..Parts::default()
        };
        Ok((whole, file))
    }

    fn new(path: &Path, plan: Option<recorder::SplitOptions>, origin: Origin, lossless: bool) -> Self {
        let since = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
        Self {
            path: path.to_owned(),
            plan,
            origin,
            lossless,
            mark: Mark {
                recording: format!("{:x}-{:x}", since.as_nanos(), std::process::id()),
                number: 0,
                is_whole: false,
            },
            number: Some(1),
            lock: None,
            began: None,
            head: 0,
            in_force: InForce::default(),
            lost: BTreeMap::new(),
            existing: VecDeque::new(),
            next_retry: Instant::now() + DELETION_RETRY,
            parts: Parts::default(),
        }
    }

    /// Returns whether a message of this time starts the next part, when the present part has `bytes` bytes.
    pub(super) fn is_over(&mut self, time: Nanos, bytes: u64) -> bool {
        let began = *self.began.get_or_insert(time);
        match self.plan.map(|plan| plan.part_size) {
            Some(PartSize::Bytes(limit)) => bytes - self.head >= limit,
            Some(PartSize::Time(limit)) => time >= began.saturating_add(limit),
            None => false,
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
    pub(super) fn lost_since_last_part(&self, lost: &BTreeMap<String, u64>) -> BTreeMap<String, u64> {
        let since = |(topic, lost): (&String, &u64)| {
            let before = self.lost.get(topic).copied().unwrap_or(0);
            (topic.clone(), lost.saturating_sub(before))
        };
        lost.iter().map(since).collect()
    }

    /// Records that a part has stated the values lost since the beginning.
    pub(super) fn report_lost(&mut self, lost: BTreeMap<String, u64>) {
        self.lost = lost;
    }

    /// Records the end of the present part, of this size.
    pub(super) fn end_part(&mut self, bytes: u64) {
        self.existing.push_back(OldPart {
            path: self.parts.last.clone(),
            bytes,
            remains: false,
        });
        // Unlocking fails on a file system without locks.
        let _ = self.lock.take().map(|file| file.unlock());
    }

    /// Deletes the present part, which has nothing but its beginning.
    pub(super) fn discard_part(&mut self) {
        if fs::remove_file(&self.parts.last).is_err() {
            return self.end_part(0);
        }
        self.lock = None;
        // The next try takes its numbers.
        self.number = Some(self.number.map_or(u32::MAX, |number| number - 1));
        self.mark.number -= 1;
        self.parts.count -= 1;
        if let Some(before) = self.existing.back() {
            self.parts.last.clone_from(&before.path);
        }
    }

    /// Starts the next part at this time, after the present part has ended. `gap` is the time before it of which nothing is
    /// recorded.
    pub(super) fn next(
        &mut self,
        channels: &[SinkChannel],
        time: Nanos,
        gap: Option<&Gap>,
    ) -> io::Result<OpenFile> {
        let file = self.create(channels, time, gap).map_err(|error| match error {
            Error::Create { error, .. } | Error::Thread(error) => error,
            taken @ (Error::Exists(_) | Error::Written(_)) => io::Error::other(taken),
        })?;
        self.began = Some(time);
        Ok(file)
    }

    /// Returns whether there is no number for a further part.
    pub(super) fn is_exhausted(&self) -> bool {
        self.number.is_none()
    }

    /// Returns the time at which the present part began, once it has a message.
    pub(super) fn began(&self) -> Option<Nanos> {
        self.began
    }

    /// Adds a gap to the status.
    pub(super) fn add_gap(&mut self, gap: Gap) {
        if self.parts.gaps.len() < MAX_GAPS {
            self.parts.gaps.push(gap);
        } else {
            self.parts.more_gaps += 1;
        }
    }

    /// Deletes the oldest parts while all parts together, including the `current_bytes` of the present one,
    /// exceed the limit. Parts that cannot be deleted, or that another recording is writing, are kept and do not count until
    /// they can be. Returns the first that the system refuses to delete, with the reason.
    pub(super) fn prune(&mut self, current_bytes: u64) -> Option<(PathBuf, String)> {
        let keep = self.plan?.max_total_bytes?;
        let now = Instant::now();
        let retries = now >= self.next_retry;
        let counts = |part: &&OldPart| retries || !part.remains;
        let mut total = self
            .existing
            .iter()
            .filter(counts)
            .map(|part| part.bytes)
            .sum::<u64>()
            + current_bytes;
        if retries {
            self.next_retry = now + DELETION_RETRY;
        }
        let mut refused = None;
        let (parts, mut index) = (&mut self.parts, 0);
        while total > keep
            && let Some(oldest) = self.existing.get_mut(index)
        {
            if oldest.remains && !retries {
                index += 1;
                continue;
            }
            total -= oldest.bytes;
            match remove(&oldest.path) {
                Ok(()) => {
                    parts.undeleted.remove(&oldest.path);
                    parts.deleted += 1;
                    self.existing.remove(index);
                }
                Err(reason) => {
                    if reason != LOCKED && refused.is_none() {
                        refused = Some((oldest.path.clone(), reason.clone()));
                    }
                    parts.undeleted.insert(oldest.path.clone(), reason);
                    oldest.remains = true;
                    index += 1;
                }
            }
        }
        refused
    }

    /// Returns the number of parts, and their paths. `None` of a recording in one file of which there is nothing to say.
    pub(super) fn parts(&self) -> Option<&Parts> {
        let parts = &self.parts;
        let is_plain = parts.count < 2 && parts.gaps.is_empty() && parts.undeleted.is_empty();
        Some(parts).filter(|_| self.plan.is_some() || !is_plain)
    }

    /// Creates the next part, in a file whose name is free. If it cannot be begun, there is no new file.
    fn create(
        &mut self,
        channels: &[SinkChannel],
        time: Nanos,
        gap: Option<&Gap>,
    ) -> Result<OpenFile, Error> {
        let (number, path, file) = loop {
            let Some(number) = self.number else {
                return Err(Error::Create {
                    path: self.path.clone(),
                    error: io::Error::other(
                        "the last number of a part is in use; move that part to another folder",
                    ),
                });
            };
            let path = numbered(&self.path, number);
            match writer::create(&path, false) {
                Err(error) if is_taken(&error) => self.number = number.checked_add(1),
                file => break (number, path, file?),
            }
        };
        let lock = file.try_clone().ok();
        let started = with_disk(file, &path).and_then(|(output, disk)| {
            let mark = Mark {
                recording: self.mark.recording.clone(),
                number: self.mark.number + 1,
                is_whole: false,
            };
            OpenFile::new(output, disk, &self.origin, Some(&mark))
                .and_then(|file| self.start_file(file, &mark, channels, time, gap))
                .map(|file| (file, mark))
                .map_err(failed(&path))
        });
        match started {
            Ok((file, mark)) => {
                (self.mark, self.lock) = (mark, lock);
                self.number = number.checked_add(1);
                self.parts.count += 1;
                if self.parts.count == 1 {
                    self.parts.first.clone_from(&path);
                }
                self.parts.last = path;
                Ok(file)
            }
            Err(error) => {
                // The next try takes its name, or the next one if it remains.
                let _ = fs::remove_file(&path);
                Err(error)
            }
        }
    }

    /// Writes the beginning of a part: its channels, and the values in force.
    fn start_file(
        &mut self,
        mut file: OpenFile,
        mark: &Mark,
        channels: &[SinkChannel],
        time: Nanos,
        gap: Option<&Gap>,
    ) -> io::Result<OpenFile> {
        channels.iter().try_for_each(|channel| file.open(channel))?;
        let log = time.saturating_sub(if self.lossless { 0 } else { MAX_LATENESS });
        for (channel, times, data) in self.in_force.iter() {
            file.repeat(channel, Times { log, ..times }, data)?;
        }
        file.flush()?;
        let head = file.bytes();
        if mark.number > 1 {
            let byte = BTreeMap::from([(BYTE.to_owned(), head.to_string())]);
            file.metadata(BEGINS, byte)?;
        }
        if let Some(gap) = gap {
            file.metadata(GAP, gap.to_metadata())?;
            file.flush()?;
        }
        self.head = head;
        Ok(file)
    }
}

fn failed(path: &Path) -> impl Fn(io::Error) -> Error {
    |error| Error::Create {
        path: path.to_owned(),
        error,
    }
}

/// Deletes a part unless another recording is writing it.
///
/// # Errors
/// Why it still exists.
fn remove(path: &Path) -> Result<(), String> {
    let opened = File::open(path).and_then(|file| match file.try_lock_shared() {
        Err(TryLockError::WouldBlock) => Ok(None),
        // While this lock is held, no recording writes the file. Without locks this cannot
        // be checked.
        Ok(()) | Err(TryLockError::Error(_)) => fs::remove_file(path).map(|()| Some(file)),
    });
    match opened {
        Ok(Some(_)) => Ok(()),
        Ok(None) => Err(LOCKED.to_owned()),
        Err(error) if error.kind() == ErrorKind::NotFound => Ok(()),
        Err(error) => Err(error.to_string()),
    }
}
