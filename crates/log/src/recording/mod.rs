//! Reading a recording back: what channels it has, and its messages in the order of their times. One in parts is read as one. One
//! that was cut off, by a power cut or a full disk, is read up to the damage. Reads any MCAP file without needing a clock, a robot or a plugin.

mod messages;
pub(crate) mod scan;

use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom};
use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use mcap::records::Record;
use mcap::sans_io::summary_reader::{SummaryReadEvent, SummaryReader};
use mcap::{McapError, Summary};

use crate::part::{self, BEGINS, BYTE, Mark, PART};
pub use messages::Messages;
use scan::Found;

/// What was lost while it was recorded, by topic.
const LOST: &str = "jde/lost";

/// A recording, open for reading.
pub struct Recording {
    path: PathBuf,
    /// In their order.
    parts: Vec<Part>,
    channels: Vec<Arc<Channel>>,
    /// In the order of their first message's times.
    chunks: Vec<Chunk>,
    metadata: BTreeMap<String, BTreeMap<String, String>>,
    /// By name, in which part each attached file is, and where.
    attached: BTreeMap<String, (usize, u64)>,
    damage: Option<Damage>,
}

/// What a topic's messages are.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Channel {
    /// `/pioneer/laser`.
    pub topic: String,
    /// Name of their type: `sensor_msgs/msg/LaserScan`.
    pub type_name: String,
    /// Form of the definition: `ros2msg`, `jsonschema`.
    pub definition_encoding: String,
    /// The definition.
    pub definition: Vec<u8>,
    /// Form of the messages: `cdr`, `json`.
    pub encoding: String,
    /// What else the recording says of it: `variable`, `access`, `doc`, `unit`.
    pub about: BTreeMap<String, String>,
}

/// One message.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Message {
    /// Its channel.
    pub channel: Arc<Channel>,
    /// When it was published, ns since 1970: the start of the application and its own clock.
    pub log_time: u64,
    /// When it was measured, likewise.
    pub publish_time: u64,
    /// Counts the values of its topic.
    pub sequence: u32,
    /// Its bytes.
    pub data: Vec<u8>,
}

/// Where a recording ends too soon.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Damage {
    /// Bytes from the beginning of the file that are whole.
    pub offset: u64,
    /// What is wrong behind them.
    pub reason: String,
}

/// Why a recording cannot be read.
#[derive(Debug, thiserror::Error)]
pub enum ReadError {
    /// The file cannot be read.
    #[error("cannot read {}: {error}", path.display())]
    File {
        /// Which.
        path: PathBuf,
        /// Why.
        error: io::Error,
    },
    /// A folder without a recording.
    #[error("{} holds no recording; name an MCAP file, or the folder of one", .0.display())]
    Nothing(PathBuf),
    /// A folder with several.
    #[error("{} holds {count} recordings; name one, such as {}", path.display(), first.display())]
    Several {
        /// The folder.
        path: PathBuf,
        /// How many.
        count: usize,
        /// A file of one of them.
        first: PathBuf,
    },
    /// It is no recording.
    #[error("{} is no MCAP file; give one that `jde run --record` has written", .0.display())]
    NotMcap(PathBuf),
    /// A part of it is damaged.
    #[error("{} is damaged at byte {offset}: {reason}; what is before can be read", path.display())]
    Damaged {
        /// Which.
        path: PathBuf,
        /// Where.
        offset: u64,
        /// What is wrong.
        reason: String,
    },
}

/// A file of a recording.
#[derive(Clone, Debug)]
struct Part {
    path: PathBuf,
    /// By its own numbers.
    channels: BTreeMap<u16, Arc<Channel>>,
    /// Its place among the parts, from 1; none if it is no part.
    number: Option<u32>,
}

/// Where a chunk is, and when its first and its last message were published.
#[derive(Clone, Copy, Debug)]
struct Chunk {
    part: usize,
    offset: u64,
    start: u64,
    end: u64,
}

impl Recording {
    /// Opens a recording: by its index, or if it was cut off by reading all of it once. Of one in parts any part, the name from which
    /// they are numbered, or a folder in which nothing else is recorded stands for all of it.
    ///
    /// # Errors
    /// [`ReadError::File`], [`ReadError::NotMcap`], and of a folder [`ReadError::Nothing`] and [`ReadError::Several`].
    pub fn open(path: &Path) -> Result<Self, ReadError> {
        let mut found = part::recordings(path).map_err(failed(path))?;
        let Some(first) = found.pop() else {
            return Err(ReadError::Nothing(path.to_owned()));
        };
        if !found.is_empty() {
            return Err(ReadError::Several {
                path: path.to_owned(),
                count: found.len() + 1,
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
        };
        for path in first {
            let found = read(&path)?;
            recording.add(path, found);
        }
        let order = |chunk: &Chunk| (chunk.start, chunk.part, chunk.offset);
        recording.chunks.sort_by_key(order);
        Ok(recording)
    }

    /// Its channels, in the order in which they were added.
    pub fn channels(&self) -> impl Iterator<Item = &Channel> {
        self.channels.iter().map(|channel| &**channel)
    }

    /// What it says of itself under a name: `jde` has `application`, `seed`, `start_ns`; `jde/lost` the number of values lost
    /// of each topic.
    #[must_use]
    pub fn metadata(&self, name: &str) -> Option<&BTreeMap<String, String>> {
        self.metadata.get(name)
    }

    /// The names of the files attached to it.
    pub fn attachments(&self) -> impl Iterator<Item = &str> {
        self.attached.keys().map(String::as_str)
    }

    /// A file attached to it; none if there is none of that name or it is damaged.
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

    /// What was opened: its file, one of its files or their folder.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Its files, in their order.
    pub fn files(&self) -> impl Iterator<Item = &Path> {
        self.parts.iter().map(|part| &*part.path)
    }

    /// The number of the first part that is there, from 1; none if it is whole in one file.
    #[must_use]
    pub fn first_part(&self) -> Option<u32> {
        self.parts.first()?.number
    }

    /// Numbers of the parts that are missing between the first and the last that are there, gap by gap: files may claim any number.
    pub fn missing(&self) -> impl Iterator<Item = RangeInclusive<u32>> {
        let numbers = || self.parts.iter().filter_map(|part| part.number);
        let between = numbers().zip(numbers().skip(1));
        between
            .map(|(one, next)| one.saturating_add(1)..=next.saturating_sub(1))
            .filter(|gap| !gap.is_empty())
    }

    /// Where it ends too soon, if it does; of several parts, where the first that does.
    #[must_use]
    pub fn damage(&self) -> Option<&Damage> {
        self.damage.as_ref()
    }

    /// All messages in the order of their log times; those of the same time in that of the file.
    ///
    /// # Errors
    /// [`ReadError::File`]. The messages themselves end with the first error.
    pub fn messages(&self) -> Result<Messages, ReadError> {
        Messages::new(self, 0)
    }

    /// Those from a log time on.
    ///
    /// # Errors
    /// As [`Self::messages`].
    pub fn messages_from(&self, log_time: u64) -> Result<Messages, ReadError> {
        Messages::new(self, log_time)
    }

    /// The log times of its first and its last message, in this order, as the file has it; none if it has none.
    #[must_use]
    pub fn times(&self) -> Option<(u64, u64)> {
        // A chunk without messages has no times.
        let chunks = || self.chunks.iter().filter(|chunk| chunk.end > 0);
        let first = chunks().map(|chunk| chunk.start).min()?;
        let last = chunks().map(|chunk| chunk.end).max()?;
        // What a file claims of its chunks need not be so.
        Some((first.min(last), last.max(first)))
    }

    /// Adds what was found in a file. What a part repeats of the part before it is left out.
    fn add(&mut self, path: PathBuf, found: Found) {
        let Found {
            summary,
            metadata,
            damage,
        } = found;
        let number = metadata.get(PART).and_then(Mark::of).map(|mark| mark.number);
        let before = self.parts.last().and_then(|part| part.number);
        let follows = before.is_some() && before.and_then(|before| before.checked_add(1)) == number;
        let news = match metadata.get(BEGINS).and_then(|begins| begins.get(BYTE)) {
            _ if !follows => 0,
            Some(byte) => byte.parse().unwrap_or(0),
            // It was cut off before it held anything new.
            None => u64::MAX,
        };
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
            let place = (part, index.offset);
            self.attached.entry(index.name.clone()).or_insert(place);
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

/// Adds numbers of values lost to others.
fn add_up(lost: &mut BTreeMap<String, String>, more: &BTreeMap<String, String>) {
    let number = |text: &str| text.parse::<u64>().unwrap_or(0);
    for (topic, more) in more {
        let lost = lost.entry(topic.clone()).or_default();
        *lost = (number(lost) + number(more)).to_string();
    }
}

fn failed(path: &Path) -> impl Fn(io::Error) -> ReadError {
    |error| ReadError::File {
        path: path.to_owned(),
        error,
    }
}

/// Reads what is in a file.
fn read(path: &Path) -> Result<Found, ReadError> {
    let mut file = File::open(path).map_err(failed(path))?;
    let mut magic = [0; mcap::MAGIC.len()];
    match file.read_exact(&mut magic) {
        Ok(()) if magic == mcap::MAGIC => {}
        Err(error) if error.kind() != io::ErrorKind::UnexpectedEof => return Err(failed(path)(error)),
        Ok(()) | Err(_) => return Err(ReadError::NotMcap(path.to_owned())),
    }
    let indexed = indexed(&mut file).map_err(failed(path))?;
    indexed.map_or_else(|| scan::scan(&mut file).map_err(failed(path)), Ok)
}

/// None if there is no index that can be read.
fn indexed(file: &mut File) -> io::Result<Option<Found>> {
    let Some(summary) = summary(file)?.filter(finds_all) else {
        return Ok(None);
    };
    let mut metadata = BTreeMap::new();
    for index in &summary.metadata_indexes {
        let Some((opcode, body)) = scan::record(file, index.offset)? else {
            return Ok(None);
        };
        match mcap::parse_record(opcode, &body) {
            Ok(Record::Metadata(one)) => metadata.insert(one.name, one.metadata),
            Ok(_) | Err(_) => return Ok(None),
        };
    }
    Ok(Some(Found {
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
            about: channel.metadata.clone(),
        }
    }
}

/// Whether an index leads to every message. Others than we may write messages into no chunk, and leave out what they like.
fn finds_all(summary: &Summary) -> bool {
    summary.stats.as_ref().is_some_and(|stats| {
        stats.chunk_count as usize == summary.chunk_indexes.len()
            && stats.attachment_count as usize == summary.attachment_indexes.len()
            && stats.metadata_count as usize == summary.metadata_indexes.len()
            && stats.channel_count as usize == summary.channels.len()
            && (stats.message_count == 0 || stats.chunk_count > 0)
    })
}

/// The index at the end of a file; none if it is not there or cannot be believed.
fn summary(file: &mut File) -> io::Result<Option<Summary>> {
    let mut reader = SummaryReader::new();
    while let Some(event) = reader.next_event() {
        match event {
            Ok(SummaryReadEvent::ReadRequest(need)) => {
                let read = file.read(reader.insert(need))?;
                reader.notify_read(read);
            }
            // A file too short for what is sought is no failure of the disk.
            Ok(SummaryReadEvent::SeekRequest(to)) => match file.seek(to) {
                Ok(at) => reader.notify_seeked(at),
                Err(error) if error.kind() == io::ErrorKind::InvalidInput => return Ok(None),
                Err(error) => return Err(error),
            },
            Err(McapError::Io(error)) if error.kind() != io::ErrorKind::UnexpectedEof => return Err(error),
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
