//! Reads a file without an index from its beginning as far as it is intact: every record, with a check of
//! every chunk's checksum.

use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::fs::File;
use std::io::{self, ErrorKind, Read, Seek, SeekFrom};
use std::sync::Arc;

use mcap::read::ChannelAccumulator;
use mcap::records::{AttachmentHeader, AttachmentIndex, ChunkHeader, ChunkIndex, Record, op};
use mcap::sans_io::linear_reader::{LinearReadEvent, LinearReader, LinearReaderOptions};
use mcap::{Channel, McapError, McapResult, Summary};

use super::Damage;

/// The size of a record's header in bytes: the opcode and the length of the body.
pub(crate) const HEAD: u64 = 9;
/// The largest factor by which a chunk may grow when it is decompressed. LZ4 cannot exceed it, so a larger
/// stated length is corrupt.
const MAX_EXPANSION: usize = 256;
/// Zstandard can exceed that factor, so a size up to this many bytes is accepted in any case.
const ALWAYS_ACCEPTED: usize = 64 << 20;
/// The largest size of a decompressed chunk in bytes, whatever its compressed size. The whole chunk is in
/// memory at once, and recorders fill chunks of a few megabytes.
const MAX_DECOMPRESSED: usize = 256 << 20;

/// The contents of a file.
pub(super) struct FileContents {
    pub(super) summary: Summary,
    pub(super) metadata: BTreeMap<String, BTreeMap<String, String>>,
    /// `None` if the file is complete. The files of other programs may be complete without an index.
    pub(super) damage: Option<Damage>,
}

/// The channels found so far, with their schemas.
#[derive(Default)]
struct ChannelIndex {
    known: ChannelAccumulator<'static>,
    ids: BTreeSet<u16>,
}

/// Reads a file as far as it is intact. A message outside any chunk becomes a chunk of its own.
///
/// # Errors
/// The error of the disk.
pub(super) fn scan(file: &mut File) -> io::Result<FileContents> {
    let mut channels = ChannelIndex::default();
    let mut summary = Summary::default();
    let mut metadata = BTreeMap::new();
    let mut offset = mcap::MAGIC.len() as u64;
    let reason = loop {
        let (opcode, body) = match record(file, offset)? {
            Some((op::DATA_END, body)) => {
                let end = offset + HEAD + body.len() as u64;
                if is_end(file, end)? {
                    break None;
                }
                break Some("the index is missing or damaged".to_owned());
            }
            Some((op::FOOTER, _)) => break Some("the index is missing or damaged".to_owned()),
            Some(record) => record,
            None if offset == file.seek(SeekFrom::End(0))? => break Some("it was cut off".to_owned()),
            None => break Some("it was cut off within a record".to_owned()),
        };
        let length = HEAD + body.len() as u64;
        let result = match opcode {
            op::CHUNK | op::SCHEMA | op::CHANNEL | op::METADATA | op::ATTACHMENT | op::MESSAGE => {
                mcap::parse_record(opcode, &body)
            }
            // Messages need nothing from these records.
            _ => Ok(Record::Unknown {
                opcode,
                data: (&[][..]).into(),
            }),
        }
        .and_then(|record| match record {
            Record::Chunk { header, .. } => {
                for_each_record(&body, |record| channels.add(record))?;
                summary.chunk_indexes.push(index(header, offset, length));
                Ok(())
            }
            Record::Message { header, .. } => {
                let time = header.log_time;
                let header = ChunkHeader {
                    message_start_time: time,
                    message_end_time: time,
                    uncompressed_size: length,
                    uncompressed_crc: 0,
                    compression: String::new(),
                    compressed_size: length,
                };
                summary.chunk_indexes.push(index(header, offset, length));
                Ok(())
            }
            Record::Attachment { header, data, .. } => {
                summary
                    .attachment_indexes
                    .push(attached(&header, offset, length, &data));
                Ok(())
            }
            Record::Metadata(entry) => {
                metadata.insert(entry.name, entry.metadata);
                Ok(())
            }
            other => channels.add(other),
        });
        if let Err(error) = result {
            break Some(error_text(&error));
        }
        offset += length;
    };
    summary.channels = channels.channels();
    Ok(FileContents {
        summary,
        metadata,
        damage: reason.map(|reason| Damage { offset, reason }),
    })
}

/// Returns whether a file without index entries is complete: after the end of its data it has a footer and
/// the closing magic bytes. An index that refers to no messages is accepted too.
fn is_end(file: &mut File, offset: u64) -> io::Result<bool> {
    let mut at = offset;
    while let Some((opcode, body)) = record(file, at)? {
        at += HEAD + body.len() as u64;
        if mcap::parse_record(opcode, &body).is_err() {
            return Ok(false);
        }
        if opcode == op::FOOTER {
            let mut magic = [0; mcap::MAGIC.len()];
            file.seek(SeekFrom::Start(at))?;
            return Ok(file.read_exact(&mut magic).is_ok() && magic == mcap::MAGIC);
        }
    }
    Ok(false)
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

/// Returns the record at an offset. `None` if the file ends before the record does.
pub(crate) fn record(file: &mut File, offset: u64) -> io::Result<Option<(u8, Vec<u8>)>> {
    // Checked before memory for the body is allocated.
    let Some((opcode, length)) = head(file, offset)? else {
        return Ok(None);
    };
    let mut body = vec![0; length as usize];
    match file.read_exact(&mut body) {
        Ok(()) => Ok(Some((opcode, body))),
        Err(error) if error.kind() == ErrorKind::UnexpectedEof => Ok(None),
        Err(error) => Err(error),
    }
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
        .with_record_length_limit(
            body.len()
                .saturating_mul(MAX_EXPANSION)
                .clamp(ALWAYS_ACCEPTED, body.len().max(MAX_DECOMPRESSED)),
        );
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
            MAX_DECOMPRESSED >> 20
        ),
        error => error.to_string(),
    }
}

impl ChannelIndex {
    fn add(&mut self, record: Record<'_>) -> McapResult<()> {
        match record {
            Record::Schema { header, data } => self.known.add_schema(header, data.into_owned().into()),
            Record::Channel(channel) => {
                self.ids.insert(channel.id);
                self.known.add_channel(channel)
            }
            _ => Ok(()),
        }
    }

    fn channels(&self) -> HashMap<u16, Arc<Channel<'static>>> {
        let known = self.ids.iter().copied();
        known.filter_map(|id| Some((id, self.known.get(id)?))).collect()
    }
}

fn attached(header: &AttachmentHeader, offset: u64, length: u64, data: &[u8]) -> AttachmentIndex {
    AttachmentIndex {
        offset,
        length,
        log_time: header.log_time,
        create_time: header.create_time,
        data_size: data.len() as u64,
        name: header.name.clone(),
        media_type: header.media_type.clone(),
    }
}

fn index(header: ChunkHeader, offset: u64, length: u64) -> ChunkIndex {
    ChunkIndex {
        message_start_time: header.message_start_time,
        message_end_time: header.message_end_time,
        chunk_start_offset: offset,
        chunk_length: length,
        message_index_offsets: BTreeMap::new(),
        message_index_length: 0,
        compression: header.compression,
        compressed_size: header.compressed_size,
        uncompressed_size: header.uncompressed_size,
    }
}
