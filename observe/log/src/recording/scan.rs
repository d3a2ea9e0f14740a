//! Reads an MCAP file without an index from its beginning as far as it is intact: every record, with a check of every chunk's
//! checksum. A chunk whose contents are damaged is noted, and what follows it is read. It passes over what needs not be in memory.

use std::collections::BTreeSet;
use std::fs::File;
use std::io::{self, BufReader, ErrorKind, Read, Seek, SeekFrom};

use jde_files::{Budget, Exceeded};
use mcap::read::ChannelAccumulator;
use mcap::records::{Record, op};
use mcap::sans_io::linear_reader::{LinearReadEvent, LinearReader, LinearReaderOptions};
use mcap::{McapError, McapResult};

use super::allowance::Allowance;
use super::mcap_file::{FileContents, UnreadChunk};
use super::{Chunk, Damage, MAX_RECORD, MessagePlace};

/// The size of a record's header in bytes: the opcode and the length of the body.
pub(crate) const HEAD: u64 = 9;
/// The largest factor by which a chunk may grow when it is decompressed. LZ4 cannot exceed it, so a larger
/// stated length is corrupt.
const MAX_EXPANSION: usize = 256;
/// Zstandard can exceed that factor, so a size up to this many bytes is accepted in any case.
const ALWAYS_ACCEPTED: usize = 64 << 20;
/// Messages outside of chunks are read together, so many bytes at once.
const RUN_BYTES: u64 = 1 << 20;
/// The part of a message before its data: channel, sequence and two times.
const MESSAGE_HEADER: usize = 22;
/// The most damaged chunks between others. A file with more is no recording with a few bad bytes.
const MAX_UNREAD: usize = 1000;
/// The longest name of an attached file, in bytes.
const MAX_NAME: u32 = 4096;

/// The channels found so far, with their schemas.
#[derive(Default)]
struct ChannelIndex {
    /// What they take while the file is scanned.
    budget: Budget,
    known: ChannelAccumulator<'static>,
    schemas: BTreeSet<u16>,
    ids: BTreeSet<u16>,
}

/// Reads one record after the other.
struct Records<'a> {
    file: BufReader<&'a File>,
    at: u64,
    end: u64,
    /// What may still be unpacked.
    allowance: Allowance,
}

/// What ends the intact part of a file.
enum Stop {
    /// The disk failed.
    Disk(io::Error),
    /// The file says something wrong here.
    Wrong(String),
}

impl From<io::Error> for Stop {
    fn from(error: io::Error) -> Self {
        Self::Disk(error)
    }
}

impl From<McapError> for Stop {
    fn from(error: McapError) -> Self {
        Self::Wrong(error_text(&error))
    }
}

impl From<Exceeded> for Stop {
    fn from(error: Exceeded) -> Self {
        Self::Wrong(error.to_string())
    }
}

/// Returns the bytes of a chunk when it is unpacked, as it states them.
pub(super) fn unpacked_bytes(chunk: &[u8]) -> u64 {
    // Behind two times.
    chunk
        .get(16..)
        .and_then(|rest| rest.first_chunk())
        .map_or(0, |bytes| u64::from_le_bytes(*bytes))
}

/// Returns the most bytes to which so many packed ones may be unpacked.
pub(super) fn most_unpacked(packed: usize, most: usize) -> usize {
    packed
        .saturating_mul(MAX_EXPANSION)
        .clamp(ALWAYS_ACCEPTED.min(most), most)
}

/// Reads a file as far as it is intact.
///
/// # Errors
/// The error of the disk.
pub(super) fn scan(file: &File, part: usize, budget: &mut Budget) -> io::Result<FileContents> {
    let end = file.metadata()?.len();
    let mut records = Records {
        file: BufReader::new(file),
        at: mcap::MAGIC.len() as u64,
        end,
        allowance: Allowance::default(),
    };
    records.file.seek(SeekFrom::Start(records.at))?;
    let mut contents = FileContents::default();
    let mut channels = ChannelIndex::default();
    let reason = loop {
        let offset = records.at;
        match one(&mut records, part, &mut channels, &mut contents, budget) {
            Ok(true) => {}
            Ok(false) => break None,
            Err(Stop::Disk(error)) if error.kind() != ErrorKind::UnexpectedEof => return Err(error),
            Err(Stop::Disk(_)) => break Some((offset, "it was cut off within a record".to_owned())),
            Err(Stop::Wrong(reason)) => break Some((offset, reason)),
        }
    };
    contents.channels = channels
        .ids
        .iter()
        .filter_map(|id| Some((*id, channels.known.get(*id)?)))
        .collect();
    contents.damage = reason.map(|(offset, reason)| Damage {
        offset: Some(offset),
        reason,
    });
    Ok(contents)
}

/// Reads the next record. Returns whether there are more.
fn one(
    records: &mut Records<'_>,
    part: usize,
    channels: &mut ChannelIndex,
    contents: &mut FileContents,
    budget: &mut Budget,
) -> Result<bool, Stop> {
    let offset = records.at;
    if offset == records.end {
        return Err(Stop::Wrong("it was cut off".to_owned()));
    }
    let (opcode, length) = records.head()?;
    let chunk = |place, start, end| Chunk {
        part,
        place,
        start,
        end,
    };
    match opcode {
        // Holes of a file are zeros.
        0 => return Err(Stop::Wrong("there is no record".to_owned())),
        op::DATA_END => {
            records.skip(length)?;
            if is_end(records)? {
                return Ok(false);
            }
            return Err(Stop::Wrong("the index is missing or damaged".to_owned()));
        }
        op::FOOTER => return Err(Stop::Wrong("the index is missing or damaged".to_owned())),
        op::CHUNK => {
            let body = records.body(length)?;
            if let Record::Chunk { header, .. } = mcap::parse_record(opcode, &body)? {
                let (mut result, mut messages) = (Ok(()), 0);
                let unpacked = for_each_record(&body, |record| {
                    messages += 1;
                    if result.is_ok() {
                        result = channels.add(record);
                    }
                    Ok(())
                });
                result?;
                match unpacked {
                    Ok(()) => {}
                    // Chunks do not need each other.
                    Err(error) if is_damage(&error) && contents.unread.len() < MAX_UNREAD => {
                        contents.unread.push(UnreadChunk {
                            offset,
                            start: header.message_start_time,
                            end: header.message_end_time,
                            reason: error_text(&error),
                        });
                        return Ok(true);
                    }
                    Err(error) => return Err(error.into()),
                }
                let taken = records.allowance.take(length, header.uncompressed_size, messages);
                taken.map_err(Stop::Wrong)?;
                budget.hold(size_of::<Chunk>())?;
                contents.chunks.push(chunk(
                    MessagePlace::At(offset),
                    header.message_start_time,
                    header.message_end_time,
                ));
            }
        }
        op::MESSAGE => {
            let mut header = [0; MESSAGE_HEADER];
            if length < header.len() as u64 || length > MAX_RECORD as u64 {
                return Err(Stop::Wrong(format!("a message has {length} bytes")));
            }
            records.read(&mut header)?;
            records.skip(length - header.len() as u64)?;
            let time = u64::from_le_bytes(*header[6..].first_chunk().unwrap_or(&[0; 8]));
            match contents.chunks.last_mut() {
                Some(Chunk {
                    place: MessagePlace::Run([first, last]),
                    start,
                    end,
                    ..
                }) if *last == offset && records.at - *first <= RUN_BYTES => {
                    *last = records.at;
                    (*start, *end) = (time.min(*start), time.max(*end));
                }
                _ => {
                    budget.hold(size_of::<Chunk>())?;
                    contents
                        .chunks
                        .push(chunk(MessagePlace::Run([offset, records.at]), time, time));
                }
            }
        }
        op::SCHEMA | op::CHANNEL => {
            let body = records.body(length)?;
            channels.add(mcap::parse_record(opcode, &body)?)?;
        }
        op::METADATA => {
            let body = records.body(length)?;
            if let Record::Metadata(entry) = mcap::parse_record(opcode, &body)? {
                budget.hold(body.len())?;
                contents.metadata.insert(entry.name, entry.metadata);
            }
        }
        op::ATTACHMENT => {
            let name = records.attachment_name(length)?;
            budget.hold(name.len() + size_of::<(String, u64)>())?;
            contents.attachments.push((name, offset));
        }
        // Messages need nothing from other records.
        _ => records.skip(length)?,
    }
    Ok(true)
}

/// Whether a chunk has other bytes than were written, so that its contents cannot be unpacked or are others.
const fn is_damage(error: &McapError) -> bool {
    matches!(
        error,
        McapError::BadChunkCrc { .. } | McapError::DecompressionError(_) | McapError::Io(_)
    )
}

/// Returns whether a file without index entries is complete: after the end of its data it has a footer and
/// the closing magic bytes. An index that refers to no messages is accepted too.
fn is_end(records: &mut Records<'_>) -> Result<bool, Stop> {
    while records.at < records.end {
        let (opcode, length) = records.head()?;
        let body = records.body(length)?;
        if mcap::parse_record(opcode, &body).is_err() {
            return Ok(false);
        }
        if opcode == op::FOOTER {
            let mut magic = [0; mcap::MAGIC.len()];
            return Ok(records.read(&mut magic).is_ok() && magic == mcap::MAGIC);
        }
    }
    Ok(false)
}

impl Records<'_> {
    /// Returns the opcode of the next record and the length of its body, which is in the file.
    fn head(&mut self) -> io::Result<(u8, u64)> {
        let mut head = [0; HEAD as usize];
        self.read(&mut head)?;
        let [opcode, length @ ..] = head;
        let length = u64::from_le_bytes(length);
        match length <= self.end - self.at {
            true => Ok((opcode, length)),
            false => Err(ErrorKind::UnexpectedEof.into()),
        }
    }

    fn read(&mut self, bytes: &mut [u8]) -> io::Result<()> {
        self.file.read_exact(bytes)?;
        self.at += bytes.len() as u64;
        Ok(())
    }

    fn skip(&mut self, bytes: u64) -> io::Result<()> {
        self.file.seek_relative(bytes.cast_signed())?;
        self.at += bytes;
        Ok(())
    }

    fn body(&mut self, length: u64) -> Result<Vec<u8>, Stop> {
        let mut body = room(length)?;
        self.read(&mut body)?;
        Ok(body)
    }

    /// Reads the name of an attached file, and passes over the file.
    fn attachment_name(&mut self, length: u64) -> Result<String, Stop> {
        let end = self.at + length;
        // Two times, and the length of the name.
        let mut head = [0; 20];
        let wrong = || Stop::Wrong("an attached file has no name".to_owned());
        if length < head.len() as u64 {
            return Err(wrong());
        }
        self.read(&mut head)?;
        let name_length = u32::from_le_bytes(*head[16..].first_chunk().unwrap_or(&[0; 4]));
        if name_length > MAX_NAME || u64::from(name_length) > end - self.at {
            return Err(wrong());
        }
        let mut name = vec![0; name_length as usize];
        self.read(&mut name)?;
        self.skip(end - self.at)?;
        String::from_utf8(name).map_err(|_| wrong())
    }
}

/// Returns memory for a record of this length.
fn room(length: u64) -> Result<Vec<u8>, Stop> {
    if length > MAX_RECORD as u64 {
        let reason = format!(
            "a record has {} MB, and at most {} MB are read",
            length >> 20,
            MAX_RECORD >> 20
        );
        return Err(Stop::Wrong(reason));
    }
    let mut body = Vec::new();
    let bytes = length as usize;
    match body.try_reserve_exact(bytes) {
        Ok(()) => {
            body.resize(bytes, 0);
            Ok(body)
        }
        Err(_) => {
            let text = format!("there is no memory for a record of {bytes} bytes");
            Err(io::Error::new(ErrorKind::OutOfMemory, text).into())
        }
    }
}

/// Returns the opcode of the record at an offset and the length of its body. `None` if the file ends before
/// the record does.
pub(crate) fn head(file: &mut File, offset: u64) -> io::Result<Option<(u8, u64)>> {
    let end = file.seek(SeekFrom::End(0))?;
    file.seek(SeekFrom::Start(offset))?;
    let mut head = [0; HEAD as usize];
    match file.read_exact(&mut head) {
        Ok(()) => {}
        Err(error) if error.kind() == ErrorKind::UnexpectedEof => return Ok(None),
        Err(error) => return Err(error),
    }
    let [opcode, length @ ..] = head;
    let length = u64::from_le_bytes(length);
    let inside = offset.saturating_add(HEAD).saturating_add(length) <= end;
    Ok(inside.then_some((opcode, length)))
}

/// Returns the record at an offset. `None` if the file ends before the record does, or if the record is too large to be read.
pub(crate) fn record(file: &mut File, offset: u64) -> io::Result<Option<(u8, Vec<u8>)>> {
    // Checked before memory for the body is allocated.
    let Some((opcode, length)) = head(file, offset)? else {
        return Ok(None);
    };
    let Ok(mut body) = room(length) else {
        return Ok(None);
    };
    match file.read_exact(&mut body) {
        Ok(()) => Ok(Some((opcode, body))),
        Err(error) if error.kind() == ErrorKind::UnexpectedEof => Ok(None),
        Err(error) => Err(error),
    }
}

/// Passes the messages from one byte of a file to another to `action`.
///
/// # Errors
/// The error of the disk, of a record, or the one that `action` returns.
pub(super) fn for_each_message(
    file: &mut File,
    [first, last]: [u64; 2],
    mut action: impl FnMut(Record<'_>) -> McapResult<()>,
) -> McapResult<()> {
    let mut offset = first;
    while offset < last {
        let Some((opcode, body)) = record(file, offset)? else {
            return Err(McapError::UnexpectedEof);
        };
        offset += HEAD + body.len() as u64;
        if opcode == op::MESSAGE {
            action(mcap::parse_record(opcode, &body)?)?;
        }
    }
    Ok(())
}

/// Passes the records of a chunk to `action`, after the whole chunk has been compared with its checksum.
/// `body` is the body of the chunk's record.
///
/// # Errors
/// The error of the chunk, or the one that `action` returns.
pub(super) fn for_each_record(
    body: &[u8],
    mut action: impl FnMut(Record<'_>) -> McapResult<()>,
) -> McapResult<()> {
    let options = LinearReaderOptions::default()
        .with_skip_start_magic(true)
        .with_skip_end_magic(true)
        .with_prevalidate_chunk_crcs(true)
        .with_record_length_limit(most_unpacked(body.len(), body.len().max(MAX_RECORD)));
    let mut reader = LinearReader::new_with_options(options);
    let mut head = vec![op::CHUNK];
    head.extend((body.len() as u64).to_le_bytes());
    let mut rest = head.chain(body);
    while let Some(event) = reader.next_event() {
        match event? {
            LinearReadEvent::ReadRequest(need) => {
                let read = rest.read(reader.insert(need))?;
                reader.notify_read(read);
            }
            LinearReadEvent::Record { data, opcode } => action(mcap::parse_record(opcode, data)?)?,
        }
    }
    Ok(())
}

/// Returns the message of an error.
pub(super) fn error_text(error: &McapError) -> String {
    match error {
        McapError::ChunkTooLarge(bytes) | McapError::RecordTooLarge { len: bytes, .. } => format!(
            "a chunk would have {} MB after decompression; the limits are {} MB, and {MAX_EXPANSION} times its compressed size",
            bytes >> 20,
            MAX_RECORD >> 20
        ),
        error => error.to_string(),
    }
}

impl ChannelIndex {
    fn add(&mut self, record: Record<'_>) -> Result<(), Stop> {
        match record {
            Record::Schema { header, data } => {
                if self.schemas.insert(header.id) {
                    self.budget.hold(header.name.len() + data.len())?;
                }
                self.known.add_schema(header, data.into_owned().into())?;
            }
            Record::Channel(channel) => {
                if self.ids.insert(channel.id) {
                    let texts = channel
                        .metadata
                        .iter()
                        .map(|(key, value)| key.len() + value.len() + 64);
                    self.budget
                        .hold(channel.topic.len() + texts.sum::<usize>() + 256)?;
                }
                self.known.add_channel(channel)?;
            }
            _ => {}
        }
        Ok(())
    }
}
