//! The contents of an MCAP file, by its index, or else by reading all of it.

use std::collections::{BTreeMap, HashMap};
use std::fs::File;
use std::io::{self, Read, Seek};
use std::path::Path;
use std::sync::Arc;

use jde_files::Budget;
use mcap::records::Record;
use mcap::sans_io::summary_reader::{SummaryReadEvent, SummaryReader, SummaryReaderOptions};
use mcap::{McapError, Summary};

use super::{Chunk, Damage, MessagePlace, scan};

/// The longest record of an index, bytes.
const MAX_INDEX_RECORD: usize = 16 << 20;
/// The longest index, bytes. A file with a longer one is read as if it had none.
const MAX_INDEX: usize = 128 << 20;

/// The contents of a file.
#[derive(Default)]
pub(super) struct FileContents {
    /// The channels, by their numbers in this file.
    pub(super) channels: HashMap<u16, Arc<mcap::Channel<'static>>>,
    pub(super) chunks: Vec<Chunk>,
    /// The names of attached files, and where they are.
    pub(super) attachments: Vec<(String, u64)>,
    pub(super) metadata: BTreeMap<String, BTreeMap<String, String>>,
    /// Chunks that cannot be read, between others.
    pub(super) unread: Vec<UnreadChunk>,
    /// `None` if the file is complete. The files of other programs may be complete without an index.
    pub(super) damage: Option<Damage>,
}

/// A chunk that is damaged: its offset, the log times of its first and its last message, and what is wrong.
pub(super) struct UnreadChunk {
    pub(super) offset: u64,
    pub(super) start: u64,
    pub(super) end: u64,
    pub(super) reason: String,
}

/// Reads the index of a file, or scans the file.
///
/// # Errors
/// The error of the disk.
pub(super) fn read(path: &Path, part: usize, budget: &mut Budget) -> io::Result<FileContents> {
    let mut file = File::open(path)?;
    let before = budget.clone();
    if let Some(contents) = read_index(&mut file, part, budget)? {
        return Ok(contents);
    }
    *budget = before;
    scan::scan(&file, part, budget)
}

/// Reads a file by its index. `None` if there is no readable index.
fn read_index(file: &mut File, part: usize, budget: &mut Budget) -> io::Result<Option<FileContents>> {
    let Some(summary) = summary(file)?.filter(is_index_complete) else {
        return Ok(None);
    };
    let mut metadata = BTreeMap::new();
    for index in &summary.metadata_indexes {
        let Some((opcode, body)) = scan::record(file, index.offset)? else {
            return Ok(None);
        };
        if budget.hold(body.len()).is_err() {
            return Ok(None);
        }
        match mcap::parse_record(opcode, &body) {
            Ok(Record::Metadata(entry)) => metadata.insert(entry.name, entry.metadata),
            Ok(_) | Err(_) => return Ok(None),
        };
    }
    if budget
        .hold(summary.chunk_indexes.len() * size_of::<Chunk>())
        .is_err()
    {
        return Ok(None);
    }
    let chunks = summary.chunk_indexes.iter().map(|index| Chunk {
        part,
        place: MessagePlace::At(index.chunk_start_offset),
        start: index.message_start_time,
        end: index.message_end_time,
    });
    let attachments = summary.attachment_indexes.iter();
    Ok(Some(FileContents {
        chunks: chunks.collect(),
        attachments: attachments
            .map(|index| (index.name.clone(), index.offset))
            .collect(),
        channels: summary.channels,
        metadata,
        unread: Vec::new(),
        damage: None,
    }))
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
    let length = file.metadata()?.len();
    let options = SummaryReaderOptions::default()
        .with_file_size(length)
        .with_record_length_limit(MAX_INDEX_RECORD);
    let mut reader = SummaryReader::new_with_options(options);
    let mut bytes = 0;
    while let Some(event) = reader.next_event() {
        match event {
            Ok(SummaryReadEvent::ReadRequest(need)) => {
                let read = file.read(reader.insert(need))?;
                reader.notify_read(read);
                bytes += read;
                if bytes > MAX_INDEX {
                    return Ok(None);
                }
            }
            // A file that is too short for the seek is not a failure of the disk.
            Ok(SummaryReadEvent::SeekRequest(to)) => match file.seek(to) {
                Ok(at) => reader.notify_seeked(at),
                Err(error) if error.kind() == io::ErrorKind::InvalidInput => return Ok(None),
                Err(error) => return Err(error),
            },
            Err(McapError::Io(error)) if error.kind() != io::ErrorKind::UnexpectedEof => return Err(error),
            Err(_) => return Ok(None),
        }
    }
    Ok(reader.finish().filter(|summary| {
        let mut places: Vec<_> = summary
            .chunk_indexes
            .iter()
            .map(|index| {
                (
                    index.chunk_start_offset,
                    index.chunk_start_offset.checked_add(index.chunk_length),
                )
            })
            .collect();
        places.sort_unstable();
        // Each is behind the one before, and within the file.
        let mut before = 0;
        places.into_iter().all(|(start, end)| {
            let is_behind = start >= before;
            before = end.unwrap_or(u64::MAX);
            is_behind && before <= length
        })
    }))
}
