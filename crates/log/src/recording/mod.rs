//! Reads recordings: their channels, and their messages in the order of their times. A recording in parts is
//! read as one. A file that was cut off, by a power cut or a full disk, is read up to the damage. Any MCAP
//! file can be read, without a clock, a robot or a plugin.

mod messages;
pub(crate) mod scan;

use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::fs::File;
use std::io::{self, ErrorKind, Read, Seek, SeekFrom};
use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use jde_files::LeftOut;
use mcap::records::Record;
use mcap::sans_io::summary_reader::{SummaryReadEvent, SummaryReader};
use mcap::{McapError, Summary};

use crate::part::{self, BEGINS, BYTE, Found, GAP, Gap, Mark, PART};
pub use messages::Messages;
use scan::FileContents;

/// The name of the metadata with the number of values lost during recording, by topic.
const LOST: &str = "jde/lost";

/// A recording, open for reading.
pub struct Recording {
    path: PathBuf,
    /// The files, in their order.
    parts: Vec<Part>,
    channels: Vec<Arc<Channel>>,
    /// The chunks, in the order of their first log times.
    chunks: Vec<Chunk>,
    metadata: BTreeMap<String, BTreeMap<String, String>>,
    /// For each attached file, by name: the index of its part, and its offset there.
    attached: BTreeMap<String, (usize, u64)>,
    damage: Option<Damage>,
    /// What was not recorded, in the order of the parts.
    gaps: Vec<Gap>,
    left_out: LeftOut,
}

/// The description of a topic's messages.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Channel {
    /// The name of the topic: `/pioneer/laser`.
    pub topic: String,
    /// The name of the type: `sensor_msgs/msg/LaserScan`.
    pub type_name: String,
    /// The encoding of the definition: `ros2msg`, `jsonschema`.
    pub definition_encoding: String,
    /// The definition.
    pub definition: Vec<u8>,
    /// The encoding of the messages: `cdr`, `json`.
    pub encoding: String,
    /// The channel's metadata: `variable`, `access`, `doc`, `unit`.
    pub metadata: BTreeMap<String, String>,
}

/// One message.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Message {
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

/// Where a recording ends too early.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Damage {
    /// The number of intact bytes from the beginning of the file.
    pub offset: u64,
    /// What is wrong after them.
    pub reason: String,
}

/// What to do with a bag of ROS 2 that is no MCAP file.
const CONVERT: &str =
    "; for another bag of ROS 2: rosbags-convert --src BAG --dst NEW_FOLDER --dst-storage mcap";

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
    #[error("{} holds no recording; name an MCAP file, or the folder of one{CONVERT}", .0.display())]
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
    #[error("{} is no MCAP file; give one that `jde run --record` has written{CONVERT}", .0.display())]
    NotMcap(PathBuf),
    /// A part of the recording is damaged.
    #[error("{} is damaged at byte {offset}: {reason}; the part before it can be read", path.display())]
    Damaged {
        /// The path of the file.
        path: PathBuf,
        /// The offset of the damage, in bytes.
        offset: u64,
        /// What is wrong.
        reason: String,
    },
}

/// A file of a recording.
#[derive(Clone, Debug)]
struct Part {
    path: PathBuf,
    /// The channels, by their numbers in this file.
    channels: BTreeMap<u16, Arc<Channel>>,
    /// Its number among the parts, from 1. `None` if the file is not a part.
    number: Option<u32>,
}

/// The position of a chunk, and the log times of its first and its last message.
#[derive(Clone, Copy, Debug)]
struct Chunk {
    part: usize,
    offset: u64,
    start: u64,
    end: u64,
}

impl Recording {
    /// Opens a recording. It reads the index, or the whole file once if the file was cut off. A recording in
    /// parts can be opened by any of its parts, by the name from which they are numbered, or by a folder that
    /// contains no other recording.
    ///
    /// # Errors
    /// [`ReadError::File`], [`ReadError::NotMcap`], and for a folder [`ReadError::Empty`] and
    /// [`ReadError::Ambiguous`].
    pub fn open(path: &Path) -> Result<Self, ReadError> {
        let Found {
            mut recordings,
            left_out,
            first_unread,
        } = part::find_recordings(path).map_err(failed(path))?;
        let Some(first) = recordings.pop() else {
            return Err(match first_unread {
                None => ReadError::Empty(path.to_owned()),
                Some((path, error)) if error.kind() == ErrorKind::InvalidData => ReadError::NotMcap(path),
                Some((path, error)) => ReadError::File { path, error },
            });
        };
        if !recordings.is_empty() {
            return Err(ReadError::Ambiguous {
                path: path.to_owned(),
                count: recordings.len() + 1,
                first: first.into_iter().next().unwrap_or_default(),
            });
        }
        let mut recording = Self {
            path: path.to_owned(),
            parts: Vec::new(),
            channels: Vec::new(),
            chunks: Vec::new(),
            metadata: BTreeMap::new(),
            attached: BTreeMap::new(),
            damage: None,
            gaps: Vec::new(),
            left_out,
        };
        for path in first {
            let found = read(&path)?;
            recording.add(path, found);
        }
        let order = |chunk: &Chunk| (chunk.start, chunk.part, chunk.offset);
        recording.chunks.sort_by_key(order);
        Ok(recording)
    }

    /// Returns the channels, in the order in which they were added.
    pub fn channels(&self) -> impl Iterator<Item = &Channel> {
        self.channels.iter().map(|channel| &**channel)
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
        let path = &self.parts[*part].path;
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
        self.parts.first()?.number
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

    /// Returns the times of which the recording has nothing, because the disk did not accept it.
    #[must_use]
    pub fn gaps(&self) -> &[Gap] {
        &self.gaps
    }

    /// Returns the files beside the recording that may belong to it and cannot be read.
    #[must_use]
    pub fn left_out(&self) -> &LeftOut {
        &self.left_out
    }

    /// Returns all messages in the order of their log times. Messages of the same time are in the order of
    /// the file.
    ///
    /// # Errors
    /// [`ReadError::File`]. The iterator ends with the first error.
    pub fn messages(&self) -> Result<Messages, ReadError> {
        Messages::new(self, 0)
    }

    /// Returns the messages from a log time on.
    ///
    /// # Errors
    /// As [`Self::messages`].
    pub fn messages_from(&self, log_time: u64) -> Result<Messages, ReadError> {
        Messages::new(self, log_time)
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

    /// Adds what was found in a file. The values that a part repeats from the part before it are omitted.
    fn add(&mut self, path: PathBuf, found: FileContents) {
        let FileContents {
            summary,
            metadata,
            damage,
        } = found;
        let number = metadata
            .get(PART)
            .and_then(Mark::from_metadata)
            .map(|mark| mark.number);
        let before = self.parts.last().and_then(|part| part.number);
        let follows = before.is_some() && before.and_then(|before| before.checked_add(1)) == number;
        let news = match metadata.get(BEGINS).and_then(|begins| begins.get(BYTE)) {
            _ if !follows => 0,
            Some(byte) => byte.parse().unwrap_or(0),
            // The part was cut off before it contained anything new.
            None => u64::MAX,
        };
        self.gaps.extend(metadata.get(GAP).and_then(Gap::from_metadata));
        let part = self.parts.len();
        let mut channels = BTreeMap::new();
        let found: BTreeMap<_, _> = summary.channels.iter().collect();
        let known = self.channels.len();
        for (id, channel) in found {
            let channel = Channel::from(&**channel);
            let same = self.channels[..known].iter().find(|known| ***known == channel);
            let channel = match same {
                Some(known) => Arc::clone(known),
                None => Arc::clone(self.channels.push_mut(Arc::new(channel))),
            };
            channels.insert(*id, channel);
        }
        let news = summary
            .chunk_indexes
            .iter()
            .filter(|index| index.chunk_start_offset >= news);
        self.chunks.extend(news.map(|index| Chunk {
            part,
            offset: index.chunk_start_offset,
            start: index.message_start_time,
            end: index.message_end_time,
        }));
        for (name, said) in metadata {
            match self.metadata.entry(name) {
                Entry::Vacant(free) => drop(free.insert(said)),
                Entry::Occupied(mut known) if known.key() == LOST => add_up(known.get_mut(), &said),
                Entry::Occupied(_) => {}
            }
        }
        for index in &summary.attachment_indexes {
            let position = (part, index.offset);
            self.attached.entry(index.name.clone()).or_insert(position);
        }
        if let Some(Damage { offset, reason }) = damage.filter(|_| self.damage.is_none()) {
            let reason = match path.file_name() {
                Some(name) if number.is_some() => format!("{}: {reason}", name.display()),
                _ => reason,
            };
            self.damage = Some(Damage { offset, reason });
        }
        self.parts.push(Part {
            path,
            channels,
            number,
        });
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

/// Reads the index of a file, or scans the file.
fn read(path: &Path) -> Result<FileContents, ReadError> {
    let mut file = File::open(path).map_err(failed(path))?;
    let mut magic = [0; mcap::MAGIC.len()];
    match file.read_exact(&mut magic) {
        Ok(()) if magic == mcap::MAGIC => {}
        Err(error) if error.kind() != ErrorKind::UnexpectedEof => return Err(failed(path)(error)),
        Ok(()) | Err(_) => return Err(ReadError::NotMcap(path.to_owned())),
    }
    let indexed = read_index(&mut file).map_err(failed(path))?;
    indexed.map_or_else(|| scan::scan(&mut file).map_err(failed(path)), Ok)
}

/// Reads a file by its index. `None` if there is no readable index.
fn read_index(file: &mut File) -> io::Result<Option<FileContents>> {
    let Some(summary) = summary(file)?.filter(is_index_complete) else {
        return Ok(None);
    };
    let mut metadata = BTreeMap::new();
    for index in &summary.metadata_indexes {
        let Some((opcode, body)) = scan::record(file, index.offset)? else {
            return Ok(None);
        };
        match mcap::parse_record(opcode, &body) {
            Ok(Record::Metadata(entry)) => metadata.insert(entry.name, entry.metadata),
            Ok(_) | Err(_) => return Ok(None),
        };
    }
    Ok(Some(FileContents {
        summary,
        metadata,
        damage: None,
    }))
}

impl From<&mcap::Channel<'_>> for Channel {
    fn from(channel: &mcap::Channel<'_>) -> Self {
        let schema = channel.schema.as_deref();
        Self {
            topic: channel.topic.clone(),
            type_name: schema.map_or(String::new(), |schema| schema.name.clone()),
            definition_encoding: schema.map_or(String::new(), |schema| schema.encoding.clone()),
            definition: schema.map_or(Vec::new(), |schema| schema.data.to_vec()),
            encoding: channel.message_encoding.clone(),
            metadata: channel.metadata.clone(),
        }
    }
}

/// Returns whether the index leads to every message. Other programs may write messages outside chunks, and
/// may leave out parts of the index.
fn is_index_complete(summary: &Summary) -> bool {
    summary.stats.as_ref().is_some_and(|stats| {
        stats.chunk_count as usize == summary.chunk_indexes.len()
            && stats.attachment_count as usize == summary.attachment_indexes.len()
            && stats.metadata_count as usize == summary.metadata_indexes.len()
            && stats.channel_count as usize == summary.channels.len()
            && (stats.message_count == 0 || stats.chunk_count > 0)
    })
}

/// Reads the index at the end of a file. `None` if there is none, or if it is not credible.
fn summary(file: &mut File) -> io::Result<Option<Summary>> {
    let mut reader = SummaryReader::new();
    while let Some(event) = reader.next_event() {
        match event {
            Ok(SummaryReadEvent::ReadRequest(need)) => {
                let read = file.read(reader.insert(need))?;
                reader.notify_read(read);
            }
            // A file that is too short for the seek is not a failure of the disk.
            Ok(SummaryReadEvent::SeekRequest(to)) => match file.seek(to) {
                Ok(at) => reader.notify_seeked(at),
                Err(error) if error.kind() == ErrorKind::InvalidInput => return Ok(None),
                Err(error) => return Err(error),
            },
            Err(McapError::Io(error)) if error.kind() != ErrorKind::UnexpectedEof => return Err(error),
            Err(_) => return Ok(None),
        }
    }
    let length = file.seek(SeekFrom::End(0))?;
    Ok(reader.finish().filter(|summary| {
        let inside = |index: &mcap::records::ChunkIndex| {
            let end = index.chunk_start_offset.checked_add(index.chunk_length);
            end.is_some_and(|end| end <= length)
        };
        summary.chunk_indexes.iter().all(inside)
    }))
}
