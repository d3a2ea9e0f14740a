//! The messages of a recording in the order of their log times. Chunks overlap in time, so all chunks that
//! begin before the next message are open at once. No others are in memory.

use std::collections::{BTreeMap, VecDeque};
use std::fs::File;
use std::io::{self, Read};
use std::sync::Arc;

use mcap::McapError;
use mcap::records::{Record, op};
use rusqlite::Connection;

use super::allowance::Allowance;
use super::source::{Form, ZSTD};
use super::{
    Channel, Chunk, Damage, MAX_RECORD, MessagePlace, Part, ReadError, RecordedMessage, Recording, failed,
    scan, sqlite,
};

/// The largest number of bytes of messages that wait for earlier ones: several chunks, and little enough for the machine's
/// memory.
const MAX_QUEUED_BYTES: usize = 256 << 20;

/// The messages of a recording in the order of their log times. The iterator ends with the first error.
pub struct Messages {
    parts: Vec<Part>,
    /// The part that was read last, and its open file.
    file: Option<(usize, OpenFile)>,
    /// Messages with an earlier log time are skipped, and those with a later one than the second.
    times: [u64; 2],
    /// Whether a channel is read, by its place in the recording. `None` if all are.
    wanted: Option<Vec<bool>>,
    /// The chunks that are not open yet, in the order of their first log times.
    chunks: VecDeque<Chunk>,
    /// Messages of open chunks, by their log time and their number among all that were read.
    queue: BTreeMap<(u64, u64), RecordedMessage>,
    /// The bytes of the messages that wait.
    queued_bytes: usize,
    /// What may still be read.
    allowance: Allowance,
    /// The number of messages read from chunks so far. It keeps messages of the same time in the order of the
    /// file.
    count: u64,
    /// The error, which is returned after all messages that could be read.
    error: Option<ReadError>,
}

enum OpenFile {
    Mcap(File),
    Sqlite(Connection),
}

/// The messages of a chunk, as they are read.
struct Collected<'a> {
    channels: &'a BTreeMap<i64, Arc<Channel>>,
    times: [u64; 2],
    wanted: Option<&'a [bool]>,
    messages: Vec<RecordedMessage>,
    /// The bytes of memory that more messages may take.
    room: usize,
    /// The bytes and the number of the messages, those that are skipped too.
    bytes: u64,
    count: u64,
    /// What is wrong.
    wrong: Option<MessageFault>,
}

/// Why a message is not read.
enum MessageFault {
    /// The file says something wrong here.
    Wrong(String),
    /// There is no memory for so many bytes.
    Memory(usize),
}

impl From<String> for MessageFault {
    fn from(reason: String) -> Self {
        Self::Wrong(reason)
    }
}

impl Messages {
    pub(super) fn new(
        recording: &Recording,
        times: [u64; 2],
        wanted: Option<Vec<bool>>,
    ) -> Result<Self, ReadError> {
        let [from, until] = times;
        Ok(Self {
            file: recording.parts.first().map(|part| open(0, part)).transpose()?,
            parts: recording.parts.clone(),
            times,
            wanted,
            chunks: recording
                .chunks
                .iter()
                .filter(|chunk| chunk.end >= from && chunk.start <= until)
                .copied()
                .collect(),
            queue: BTreeMap::new(),
            queued_bytes: 0,
            allowance: Allowance::default(),
            count: 0,
            error: None,
        })
    }

    /// Opens all chunks that may contain the next message.
    fn open(&mut self) -> Result<(), ReadError> {
        while let Some(chunk) = self.chunks.front().copied() {
            let next = self.queue.first_key_value().map(|((log_time, _), _)| *log_time);
            if next.is_some_and(|next| next < chunk.start) {
                return Ok(());
            }
            self.chunks.pop_front();
            self.load(chunk)?;
        }
        Ok(())
    }

    fn load(&mut self, chunk: Chunk) -> Result<(), ReadError> {
        let part = &self.parts[chunk.part];
        let damaged = |reason: String| ReadError::Damaged {
            path: part.path.clone(),
            damage: Damage {
                offset: chunk.place.offset(),
                reason,
            },
        };
        let (_, file) = match &mut self.file {
            Some(file) if file.0 == chunk.part => file,
            other => other.insert(open(chunk.part, part)?),
        };
        let mut collected = Collected {
            channels: &part.channels,
            times: self.times,
            wanted: self.wanted.as_deref(),
            messages: Vec::new(),
            room: MAX_QUEUED_BYTES.saturating_sub(self.queued_bytes),
            bytes: 0,
            count: 0,
            wrong: None,
        };
        // The bytes of a chunk, packed and unpacked: it may have anything but messages, too.
        let mut of_chunk = None;
        let result = match (file, chunk.place) {
            (OpenFile::Mcap(file), MessagePlace::At(offset)) => {
                let read = scan::record(file, offset).map_err(failed(&part.path))?;
                match read {
                    Some((op::CHUNK, body)) => {
                        of_chunk = Some((body.len() as u64, scan::unpacked_bytes(&body)));
                        scan::for_each_record(&body, |record| collected.add_record(record))
                    }
                    Some(_) => {
                        return Err(damaged(
                            "there is no chunk here, although the index refers to one".to_owned(),
                        ));
                    }
                    None => return Err(damaged(super::damage::CUT_OFF.to_owned())),
                }
                .map_err(|error| scan::error_text(&error).into())
            }
            (OpenFile::Mcap(file), MessagePlace::Run(run)) => {
                let read = scan::for_each_message(file, run, |record| collected.add_record(record));
                read.map_err(|error| scan::error_text(&error).into())
            }
            (OpenFile::Sqlite(connection), MessagePlace::Rows(rows)) => {
                sqlite::for_each_message(connection, rows, |topic, row, time, data| {
                    // The numbers of rows restart at 0 after the largest that a message can have.
                    collected.add(topic, row as u32, [time, time], data)
                })
            }
            (OpenFile::Mcap(_), MessagePlace::Rows(_))
            | (OpenFile::Sqlite(_), MessagePlace::At(_) | MessagePlace::Run(_)) => Ok(()),
        };
        match collected.wrong.take().or(result.err()) {
            Some(MessageFault::Wrong(reason)) => return Err(damaged(reason)),
            Some(MessageFault::Memory(bytes)) => {
                let text = format!("there is no memory for a message of {bytes} bytes");
                let error = io::Error::new(io::ErrorKind::OutOfMemory, text);
                return Err(failed(&part.path)(error));
            }
            None => {}
        }
        let Collected {
            messages,
            bytes,
            count,
            ..
        } = collected;
        let (packed, bytes) = of_chunk.unwrap_or((bytes + count * scan::HEAD, bytes));
        self.allowance.take(packed, bytes, count).map_err(damaged)?;
        self.queued_bytes += messages.iter().map(size).sum::<usize>();
        for message in messages {
            self.count += 1;
            self.queue.insert((message.log_time, self.count), message);
        }
        Ok(())
    }
}

impl Collected<'_> {
    fn add_record(&mut self, record: Record<'_>) -> Result<(), McapError> {
        if let Record::Message { header, data } = record
            && self.wrong.is_none()
        {
            let times = [header.log_time, header.publish_time];
            self.wrong = self
                .add(i64::from(header.channel_id), header.sequence, times, &data)
                .err();
        }
        Ok(())
    }

    /// Adds a message. Those that were packed one by one are unpacked.
    fn add(
        &mut self,
        channel: i64,
        sequence: u32,
        [log_time, publish_time]: [u64; 2],
        data: &[u8],
    ) -> Result<(), MessageFault> {
        self.bytes += data.len() as u64;
        self.count += 1;
        let [from, until] = self.times;
        if log_time < from || log_time > until {
            return Ok(());
        }
        let Some(channel) = self.channels.get(&channel) else {
            let reason = format!("a message is on channel {channel}, which is not defined");
            return Err(reason.into());
        };
        if self
            .wanted
            .is_some_and(|wanted| wanted.get(channel.index) != Some(&true))
        {
            return Ok(());
        }
        // No message in CDR begins like that.
        let data = match channel.encoding == "cdr" && data.starts_with(&ZSTD) {
            true => unpack(data, self.room)?,
            false => copy(data, self.room)?,
        };
        let message = RecordedMessage {
            channel: Arc::clone(channel),
            log_time,
            publish_time,
            sequence,
            data,
        };
        self.room = self.room.checked_sub(size(&message)).ok_or_else(too_many)?;
        self.messages.push(message);
        Ok(())
    }
}

fn copy(data: &[u8], room: usize) -> Result<Vec<u8>, MessageFault> {
    let mut copied = Vec::new();
    if data.len() > room {
        return Err(too_many().into());
    }
    copied
        .try_reserve_exact(data.len())
        .map_err(|_| MessageFault::Memory(data.len()))?;
    copied.extend_from_slice(data);
    Ok(copied)
}

fn unpack(data: &[u8], room: usize) -> Result<Vec<u8>, String> {
    let most = scan::most_unpacked(data.len(), MAX_RECORD).min(room);
    let mut unpacked = Vec::new();
    let read = zstd::Decoder::with_buffer(data).and_then(|packed| {
        let mut packed = packed.take(most as u64 + 1);
        packed.read_to_end(&mut unpacked)
    });
    match read {
        Ok(bytes) if bytes <= most => Ok(unpacked),
        Ok(_) => Err(format!(
            "a message would have more than {} MB after decompression",
            most >> 20
        )),
        Err(error) => Err(format!("a message cannot be decompressed: {error}")),
    }
}

fn too_many() -> String {
    format!(
        "its chunks overlap so much in time that more than {} MB would be in memory at once",
        MAX_QUEUED_BYTES >> 20
    )
}

fn open(index: usize, part: &Part) -> Result<(usize, OpenFile), ReadError> {
    let path = part.source.path();
    let file = match part.source.form {
        Form::Mcap => OpenFile::Mcap(File::open(path).map_err(failed(&part.path))?),
        Form::Sqlite => {
            let opened = sqlite::open(path);
            let opened = opened.map_err(|error| failed(&part.path)(std::io::Error::other(error)))?;
            OpenFile::Sqlite(opened)
        }
    };
    Ok((index, file))
}

impl Iterator for Messages {
    type Item = Result<RecordedMessage, ReadError>;

    fn next(&mut self) -> Option<Self::Item> {
        if let Err(error) = self.open() {
            self.chunks.clear();
            self.error = Some(error);
        }
        match self.queue.pop_first() {
            Some((_, message)) => {
                self.queued_bytes -= size(&message);
                Some(Ok(message))
            }
            None => self.error.take().map(Err),
        }
    }
}

/// Returns the bytes of memory that a message takes.
fn size(message: &RecordedMessage) -> usize {
    size_of::<((u64, u64), RecordedMessage)>() + message.data.len()
}
