//! Reading a recording back: what channels it has, and its messages in the order of their times. One that was cut off, by a
//! power cut or a full disk, is read up to the damage. Reads any MCAP file without needing a clock, a robot or a plugin.

mod messages;
mod scan;

use std::collections::BTreeMap;
use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use mcap::records::Record;
use mcap::sans_io::summary_reader::{SummaryReadEvent, SummaryReader};
use mcap::{McapError, Summary};

pub use messages::Messages;

/// A recording, open for reading.
pub struct Recording {
    path: PathBuf,
    channels: BTreeMap<u16, Arc<Channel>>,
    /// In the order of their first message's times.
    chunks: Vec<Chunk>,
    metadata: BTreeMap<String, BTreeMap<String, String>>,
    /// By name, where each attached file is.
    attached: BTreeMap<String, u64>,
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

/// Where a chunk is, and when its first and its last message were published.
#[derive(Clone, Copy, Debug)]
struct Chunk {
    offset: u64,
    start: u64,
    end: u64,
}

impl Recording {
    /// Opens a recording: by its index, or if it was cut off by reading all of it once.
    ///
    /// # Errors
    /// [`ReadError::File`], [`ReadError::NotMcap`].
    pub fn open(path: &Path) -> Result<Self, ReadError> {
        let failed = |error| ReadError::File {
            path: path.to_owned(),
            error,
        };
        let mut file = File::open(path).map_err(failed)?;
        let mut magic = [0; mcap::MAGIC.len()];
        match file.read_exact(&mut magic) {
            Ok(()) if magic == mcap::MAGIC => {}
            Err(error) if error.kind() != io::ErrorKind::UnexpectedEof => return Err(failed(error)),
            Ok(()) | Err(_) => return Err(ReadError::NotMcap(path.to_owned())),
        }
        if let Some(recording) = Self::indexed(path, &mut file).map_err(failed)? {
            return Ok(recording);
        }
        let found = scan::scan(&mut file).map_err(failed)?;
        Ok(Self::new(path, &found.summary, found.metadata, found.damage))
    }

    /// Its channels, in the order in which they were added.
    pub fn channels(&self) -> impl Iterator<Item = &Channel> {
        self.channels.values().map(|channel| &**channel)
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
        let Some(offset) = self.attached.get(name) else {
            return Ok(None);
        };
        let failed = |error| ReadError::File {
            path: self.path.clone(),
            error,
        };
        let mut file = File::open(&self.path).map_err(failed)?;
        let record = scan::record(&mut file, *offset).map_err(failed)?;
        Ok(
            record.and_then(|(opcode, body)| match mcap::parse_record(opcode, &body) {
                Ok(Record::Attachment { data, .. }) => Some(data.into_owned()),
                Ok(_) | Err(_) => None,
            }),
        )
    }

    /// Its file.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Where it ends too soon, if it does.
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

    /// The log times of its first and its last message; none if it has none.
    #[must_use]
    pub fn times(&self) -> Option<(u64, u64)> {
        // A chunk without messages has no times.
        let chunks = || self.chunks.iter().filter(|chunk| chunk.end > 0);
        let first = chunks().map(|chunk| chunk.start).min()?;
        let last = chunks().map(|chunk| chunk.end).max()?;
        Some((first, last))
    }

    /// None if there is no index that can be read.
    fn indexed(path: &Path, file: &mut File) -> io::Result<Option<Self>> {
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
        Ok(Some(Self::new(path, &summary, metadata, None)))
    }

    fn new(
        path: &Path,
        summary: &Summary,
        metadata: BTreeMap<String, BTreeMap<String, String>>,
        damage: Option<Damage>,
    ) -> Self {
        let channels = summary.channels.iter();
        let mut chunks: Vec<_> = summary
            .chunk_indexes
            .iter()
            .map(|index| Chunk {
                offset: index.chunk_start_offset,
                start: index.message_start_time,
                end: index.message_end_time,
            })
            .collect();
        chunks.sort_by_key(|chunk| (chunk.start, chunk.offset));
        Self {
            path: path.to_owned(),
            channels: channels
                .map(|(id, channel)| (*id, Arc::new(Channel::from(&**channel))))
                .collect(),
            chunks,
            metadata,
            attached: summary
                .attachment_indexes
                .iter()
                .map(|index| (index.name.clone(), index.offset))
                .collect(),
            damage,
        }
    }
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
