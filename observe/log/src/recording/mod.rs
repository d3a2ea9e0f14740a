//! Reads recordings: their channels, and their messages in the order of their times. A recording in parts is
//! read as one. A file that was cut off, by a power cut or a full disk, is read up to the damage. Any MCAP
//! file and any bag of ROS 2 can be read, without a clock, a robot or a plugin.

mod allowance;
mod channel;
mod damage;
mod mcap_file;
mod messages;
pub(crate) mod scan;
mod source;
mod sqlite;

use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::fs::File;
use std::io::{self, ErrorKind};
use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use jde_files::{Budget, Exceeded, LeftOut};
use mcap::records::Record;

use crate::bag;
use crate::part::{self, BEGINS, BYTE, Found, GAP, Gap, Mark, PART};
pub use channel::Channel;
use channel::Channels;
pub use damage::Damage;
use damage::{CUT_OFF, is_being_written};
pub use messages::Messages;
pub(crate) use source::is_of_bag;
use source::{Form, Source};

/// The name of the metadata with the number of values lost during recording, by topic.
const LOST: &str = "jde/lost";
/// The largest record of a file, packed or not, in bytes. The whole record is in memory at once, and recorders fill chunks of
/// a few megabytes.
const MAX_RECORD: usize = 128 << 20;

/// A recording, open for reading.
pub struct Recording {
    path: PathBuf,
    /// Whether it has one file.
    is_alone: bool,
    /// The files, in their order.
    parts: Vec<Part>,
    channels: Channels,
    /// The chunks, in the order of their first log times.
    chunks: Vec<Chunk>,
    metadata: BTreeMap<String, BTreeMap<String, String>>,
    /// For each attached file, by name: the index of its part, and its offset there.
    attached: BTreeMap<String, (usize, u64)>,
    damage: Option<Damage>,
    /// What was not recorded or cannot be read, in the order of the parts.
    gaps: Vec<Gap>,
    left_out: LeftOut,
}

/// One message.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RecordedMessage {
    /// Its channel.
    pub channel: Arc<Channel>,
    /// The time of publication, in ns since 1970: the application's start plus its clock.
    pub log_time: u64,
    /// The time of measurement, in ns since 1970.
    pub publish_time: u64,
    /// The number of the value within its topic.
    pub sequence: u32,
    /// Its bytes.
    pub data: Vec<u8>,
}

/// What to do with a bag that is none of ROS 2 in MCAP or SQLite.
const CONVERT: &str = "; for a bag of ROS 1 or of another storage: rosbags-convert --src BAG --dst NEW_FOLDER --dst-storage mcap";

/// Why a recording cannot be read.
#[derive(Debug, thiserror::Error)]
pub enum ReadError {
    /// The file cannot be read.
    #[error("cannot read {}: {error}", path.display())]
    File {
        /// The path of the file.
        path: PathBuf,
        /// The cause.
        error: io::Error,
    },
    /// A folder that contains no recording.
    #[error("{} holds no recording; name an MCAP file, a bag of ROS 2, or the folder of one{CONVERT}", .0.display())]
    Empty(PathBuf),
    /// A folder that contains several recordings.
    #[error("{} holds {count} recordings; name one, such as {}", path.display(), first.display())]
    Ambiguous {
        /// The folder.
        path: PathBuf,
        /// The number of recordings.
        count: usize,
        /// A file of one of them.
        first: PathBuf,
    },
    /// The file is not a recording.
    #[error("{} is no MCAP file and no bag of ROS 2; give one that `jde run --record` has written{CONVERT}", .0.display())]
    NotRecording(PathBuf),
    /// A part of the recording is damaged.
    #[error("{} is damaged {damage}; the part before it can be read", path.display())]
    Damaged {
        /// The path of the file.
        path: PathBuf,
        /// Where, and what is wrong.
        damage: Damage,
    },
}

/// A file of a recording.
#[derive(Clone, Debug)]
struct Part {
    path: PathBuf,
    source: Arc<Source>,
    /// The channels, by their numbers in this file.
    channels: BTreeMap<i64, Arc<Channel>>,
    /// Its number among the parts, from 1. `None` if the file is not a part.
    number: Option<u32>,
    /// Whether it was to be the only file.
    is_whole: bool,
}

/// The position of a chunk, and the log times of its first and its last message.
#[derive(Clone, Copy, Debug)]
struct Chunk {
    part: usize,
    place: MessagePlace,
    start: u64,
    end: u64,
}

/// Where messages are in their file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum MessagePlace {
    /// In the chunk at this offset.
    At(u64),
    /// Outside of chunks, from one offset to another.
    Run([u64; 2]),
    /// In these rows, the first and the last.
    Rows([i64; 2]),
}

impl MessagePlace {
    /// Returns the offset, in bytes, in a file whose bytes have an order.
    const fn offset(self) -> Option<u64> {
        match self {
            Self::At(offset) | Self::Run([offset, _]) => Some(offset),
            Self::Rows(_) => None,
        }
    }
}

impl Recording {
    /// Opens a recording. It reads the index, or the whole file once if the file was cut off. A recording in
    /// parts can be opened by any of its parts, by the name from which they are numbered, or by a folder that
    /// contains no other recording. A bag of ROS 2 is opened by its folder, and its files are those that its
    /// `metadata.yaml` lists.
    ///
    /// # Errors
    /// [`ReadError::File`], [`ReadError::NotRecording`], and for a folder [`ReadError::Empty`] and
    /// [`ReadError::Ambiguous`].
    pub fn open(path: &Path) -> Result<Self, ReadError> {
        let bag = match path.is_dir() {
            true => bag::find(path).map_err(failed(path))?,
            false => None,
        };
        let Found {
            mut recordings,
            left_out,
            first_unread,
        } = match bag {
            Some(bag) => Found {
                recordings: vec![bag.files],
                left_out: bag.left_out,
                first_unread: None,
            },
            None => part::find_recordings(path).map_err(failed(path))?,
        };
        let Some(files) = recordings.pop() else {
            return Err(match first_unread {
                None => ReadError::Empty(path.to_owned()),
                Some((path, error)) if error.kind() == ErrorKind::InvalidData => {
                    ReadError::NotRecording(path)
                }
                Some((path, error)) => ReadError::File { path, error },
            });
        };
        if !recordings.is_empty() {
            return Err(ReadError::Ambiguous {
                path: path.to_owned(),
                count: recordings.len() + 1,
                first: files.into_iter().next().unwrap_or_default(),
            });
        }
        if files.is_empty() {
            return Err(ReadError::Empty(path.to_owned()));
        }
        let mut recording = Self {
            path: path.to_owned(),
            is_alone: files.len() == 1,
            parts: Vec::new(),
            channels: Channels::default(),
            chunks: Vec::new(),
            metadata: BTreeMap::new(),
            attached: BTreeMap::new(),
            damage: None,
            gaps: Vec::new(),
            left_out,
        };
        let mut budget = Budget::default();
        let mut first_error = None;
        for path in files {
            if let Err(error) = recording.read(&path, &mut budget) {
                let name = path.file_name().unwrap_or_default().display().to_string();
                recording
                    .left_out
                    .add(format_args!("the file {name}"), None, &error);
                first_error.get_or_insert(error);
            }
        }
        if let Some(error) = first_error.filter(|_| recording.parts.is_empty()) {
            return Err(error);
        }
        let order = |chunk: &Chunk| (chunk.start, chunk.part, chunk.place);
        recording.chunks.sort_by_key(order);
        Ok(recording)
    }

    /// Adds a file. The values that a part repeats from the part before it are omitted.
    fn read(&mut self, path: &Path, budget: &mut Budget) -> Result<(), ReadError> {
        let source = Source::new(path)?;
        let number = self.parts.len();
        match source.form {
            Form::Mcap => {
                let mut contents = mcap_file::read(source.path(), number, budget).map_err(failed(path))?;
                if let Some(damage) = &mut contents.damage
                    && damage.reason.starts_with(CUT_OFF)
                    && is_being_written(path)
                {
                    Damage::UNFINISHED.clone_into(&mut damage.reason);
                }
                self.add_mcap(path, source, contents, budget)
            }
            Form::Sqlite => {
                let bytes = source.path().metadata().map_err(failed(path))?.len();
                let opened = sqlite::open(source.path());
                let connection = opened.map_err(|error| failed(path)(io::Error::other(error)))?;
                let contents = sqlite::contents(&connection, number, bytes);
                self.add_database(path, source, contents, budget)
            }
        }
        .map_err(|error| failed(path)(io::Error::other(error)))
    }

    /// Returns what of the files cannot be read. [`RecordedVariables`](crate::RecordedVariables) adds the topics.
    #[must_use]
    pub const fn left_out(&self) -> &LeftOut {
        &self.left_out
    }

    /// Returns the channels, in the order in which they were added.
    pub fn channels(&self) -> impl Iterator<Item = &Channel> {
        self.channels.iter()
    }

    /// Returns the metadata of this name. `jde` contains `application`, `seed` and `start_ns`. `jde/lost`
    /// contains the number of lost values of each topic.
    #[must_use]
    pub fn metadata(&self, name: &str) -> Option<&BTreeMap<String, String>> {
        self.metadata.get(name)
    }

    /// Returns the names of the attached files.
    pub fn attachments(&self) -> impl Iterator<Item = &str> {
        self.attached.keys().map(String::as_str)
    }

    /// Returns an attached file. `None` if there is none of that name, or if it is damaged.
    ///
    /// # Errors
    /// [`ReadError::File`].
    pub fn attachment(&self, name: &str) -> Result<Option<Vec<u8>>, ReadError> {
        let Some((part, offset)) = self.attached.get(name) else {
            return Ok(None);
        };
        let path = self.parts[*part].source.path();
        let mut file = File::open(path).map_err(failed(path))?;
        let record = scan::record(&mut file, *offset).map_err(failed(path))?;
        Ok(
            record.and_then(|(opcode, body)| match mcap::parse_record(opcode, &body) {
                Ok(Record::Attachment { data, .. }) => Some(data.into_owned()),
                Ok(_) | Err(_) => None,
            }),
        )
    }

    /// Returns the path that was opened: a file, the name of its parts, or their folder.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Returns the files, in their order.
    pub fn files(&self) -> impl Iterator<Item = &Path> {
        self.parts.iter().map(|part| &*part.path)
    }

    /// Returns the number of the first existing part, from 1. `None` if the recording is a single file.
    #[must_use]
    pub fn first_part(&self) -> Option<u32> {
        let first = self.parts.first()?;
        first.number.filter(|_| self.parts.len() > 1 || !first.is_whole)
    }

    /// Returns the numbers of the missing parts between the first and the last existing one, as ranges. A
    /// range may be long, because a file may state any number.
    pub fn missing(&self) -> impl Iterator<Item = RangeInclusive<u32>> {
        let numbers = || self.parts.iter().filter_map(|part| part.number);
        let between = numbers().zip(numbers().skip(1));
        between
            .map(|(number, next)| number.saturating_add(1)..=next.saturating_sub(1))
            .filter(|gap| !gap.is_empty())
    }

    /// Returns where the recording ends too early, if it does. In a recording in parts, that is the first
    /// damage.
    #[must_use]
    pub fn damage(&self) -> Option<&Damage> {
        self.damage.as_ref()
    }

    /// Returns the times of which the recording has nothing, because the disk did not accept it, or because the file is
    /// damaged there.
    #[must_use]
    pub fn gaps(&self) -> &[Gap] {
        &self.gaps
    }

    /// Returns all messages in the order of their log times. Messages of the same time are in the order of
    /// the file.
    ///
    /// # Errors
    /// [`ReadError::File`]. The iterator ends with the first error.
    pub fn messages(&self) -> Result<Messages, ReadError> {
        Messages::new(self, [0, u64::MAX], None)
    }

    /// Returns the messages from a log time on.
    ///
    /// # Errors
    /// As [`Self::messages`].
    pub fn messages_from(&self, log_time: u64) -> Result<Messages, ReadError> {
        Messages::new(self, [log_time, u64::MAX], None)
    }

    /// Returns the messages of some channels from one log time to another, both included. Chunks of other times are not
    /// read, and messages of other channels are not copied.
    ///
    /// # Errors
    /// As [`Self::messages`].
    pub fn messages_of(
        &self,
        times: RangeInclusive<u64>,
        is_wanted: impl Fn(&Channel) -> bool,
    ) -> Result<Messages, ReadError> {
        let wanted = self.channels().map(is_wanted).collect();
        Messages::new(self, [*times.start(), *times.end()], Some(wanted))
    }

    /// Returns the log times of the first and the last message, the lesser one first, as the chunks' headers
    /// state them. `None` if there are no messages.
    #[must_use]
    pub fn times(&self) -> Option<(u64, u64)> {
        // A chunk without messages has no times.
        let chunks = || self.chunks.iter().filter(|chunk| chunk.end > 0);
        let first = chunks().map(|chunk| chunk.start).min()?;
        let last = chunks().map(|chunk| chunk.end).max()?;
        // The headers of the chunks may be wrong.
        Some((first.min(last), last.max(first)))
    }

    fn add_mcap(
        &mut self,
        path: &Path,
        source: Source,
        found: mcap_file::FileContents,
        budget: &mut Budget,
    ) -> Result<(), Exceeded> {
        let mark = found.metadata.get(PART).and_then(Mark::from_metadata);
        let number = mark.as_ref().map(|mark| mark.number);
        let is_whole = mark.is_some_and(|mark| mark.is_whole);
        let before = self.parts.last().and_then(|part| part.number);
        let follows = before.is_some() && before.and_then(|before| before.checked_add(1)) == number;
        let news = match found.metadata.get(BEGINS).and_then(|begins| begins.get(BYTE)) {
            _ if !follows => 0,
            Some(byte) => byte.parse().unwrap_or(0),
            // The part was cut off before it contained anything new.
            None => u64::MAX,
        };
        self.gaps
            .extend(found.metadata.get(GAP).and_then(Gap::from_metadata));
        // The times of gaps are those of the application.
        let start = found.metadata.get("jde").or(self.metadata.get("jde"));
        let start = start.and_then(|jde| jde.get("start_ns")?.parse::<u64>().ok());
        let start = start.unwrap_or_else(|| found.chunks.iter().map(|chunk| chunk.start).min().unwrap_or(0));
        self.gaps.extend(found.unread.into_iter().map(|chunk| Gap {
            from: chunk.start.saturating_sub(start),
            until: Some(chunk.end.saturating_sub(start)),
            lost: 0,
            reason: format!("the file is damaged at byte {}: {}", chunk.offset, chunk.reason),
            damaged: true,
        }));
        let sorted: BTreeMap<_, _> = found.channels.iter().collect();
        let mut channels = BTreeMap::new();
        let mut definitions = self.channels.definitions_of_file();
        for (id, channel) in sorted {
            channels.insert(i64::from(*id), definitions.add(channel, budget)?);
        }
        let is_new = |chunk: &Chunk| chunk.place.offset().is_none_or(|offset| offset >= news);
        self.chunks.extend(found.chunks.into_iter().filter(is_new));
        for (name, said) in found.metadata {
            match self.metadata.entry(name) {
                Entry::Vacant(free) => drop(free.insert(said)),
                Entry::Occupied(mut known) if known.key() == LOST => add_up(known.get_mut(), &said),
                Entry::Occupied(_) => {}
            }
        }
        for (name, offset) in found.attachments {
            let position = (self.parts.len(), offset);
            self.attached.entry(name).or_insert(position);
        }
        let is_named = number.is_some() && !(is_whole && self.is_alone);
        self.add_damage(path, found.damage, is_named);
        self.parts.push(Part {
            path: path.to_owned(),
            source: Arc::new(source),
            channels,
            number,
            is_whole,
        });
        Ok(())
    }

    fn add_database(
        &mut self,
        path: &Path,
        source: Source,
        found: sqlite::Contents,
        budget: &mut Budget,
    ) -> Result<(), Exceeded> {
        budget.hold(found.chunks.len() * size_of::<Chunk>())?;
        let mut channels = BTreeMap::new();
        for (id, channel) in found.channels {
            channels.insert(id, self.channels.add(channel, budget)?);
        }
        self.chunks.extend(found.chunks);
        let damage = found.damage.map(|reason| Damage { offset: None, reason });
        self.add_damage(path, damage, false);
        self.parts.push(Part {
            path: path.to_owned(),
            source: Arc::new(source),
            channels,
            number: None,
            is_whole: false,
        });
        Ok(())
    }

    fn add_damage(&mut self, path: &Path, damage: Option<Damage>, is_named: bool) {
        if let Some(Damage { offset, reason }) = damage.filter(|_| self.damage.is_none()) {
            let reason = match path.file_name() {
                Some(name) if is_named => format!("{}: {reason}", name.display()),
                _ => reason,
            };
            self.damage = Some(Damage { offset, reason });
        }
    }
}

/// Adds the numbers of lost values in `more` to those in `lost`.
fn add_up(lost: &mut BTreeMap<String, String>, more: &BTreeMap<String, String>) {
    let number = |text: &str| text.parse::<u64>().unwrap_or(0);
    for (topic, more) in more {
        let lost = lost.entry(topic.clone()).or_default();
        *lost = number(lost).saturating_add(number(more)).to_string();
    }
}

fn failed(path: &Path) -> impl Fn(io::Error) -> ReadError {
    |error| ReadError::File {
        path: path.to_owned(),
        error,
    }
}
