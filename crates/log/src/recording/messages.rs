//! The messages of a recording in the order of their log times. Chunks overlap in time, so all chunks that
//! begin before the next message are open at once. No others are in memory.

use std::collections::{BTreeMap, VecDeque};
use std::fs::File;
use std::sync::Arc;

use mcap::records::{Record, op};

use super::{Chunk, Message, Part, ReadError, Recording, failed, scan};

/// The largest number of bytes of messages that wait for earlier ones: several chunks of the greatest size,
/// and little enough for the machine's memory.
const MAX_QUEUED_BYTES: usize = 1 << 30;

/// The messages of a recording in the order of their log times. The iterator ends with the first error.
pub struct Messages {
    parts: Vec<Part>,
    /// The part that was read last, and its open file.
    file: Option<(usize, File)>,
    /// Messages with an earlier log time are skipped.
    from: u64,
    /// The chunks that are not open yet, in the order of their first log times.
    chunks: VecDeque<Chunk>,
    /// Messages of open chunks, by their log time and their number among all that were read.
    queue: BTreeMap<(u64, u64), Message>,
    /// The bytes of the messages that wait.
    queued_bytes: usize,
    /// The number of messages read from chunks so far. It keeps messages of the same time in the order of the
    /// file.
    count: u64,
    /// The error, which is returned after all messages that could be read.
    error: Option<ReadError>,
}

impl Messages {
    pub(super) fn new(recording: &Recording, from: u64) -> Result<Self, ReadError> {
        Ok(Self {
            file: recording.parts.first().map(|part| open(0, part)).transpose()?,
            parts: recording.parts.clone(),
            from,
            chunks: recording
                .chunks
                .iter()
                .filter(|chunk| chunk.end >= from)
                .copied()
                .collect(),
            queue: BTreeMap::new(),
            queued_bytes: 0,
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
            offset: chunk.offset,
            reason,
        };
        let (_, file) = match &mut self.file {
            Some(file) if file.0 == chunk.part => file,
            other => other.insert(open(chunk.part, part)?),
        };
        let read = scan::record(file, chunk.offset).map_err(failed(&part.path))?;
        let Some((opcode, body)) = read else {
            return Err(damaged("it was cut off".to_owned()));
        };
        let mut messages = Vec::new();
        let mut undefined_channel = None;
        let collect = |record: Record<'_>| {
            if let Record::Message { header, data } = record
                && header.log_time >= self.from
            {
                match part.channels.get(&header.channel_id) {
                    Some(channel) => messages.push(Message {
                        channel: Arc::clone(channel),
                        log_time: header.log_time,
                        publish_time: header.publish_time,
                        sequence: header.sequence,
                        data: data.into_owned(),
                    }),
                    None => undefined_channel = Some(header.channel_id),
                }
            }
            Ok(())
        };
        let result = match opcode {
            op::CHUNK => scan::for_each_record(&body, collect),
            op::MESSAGE => mcap::parse_record(opcode, &body).and_then(collect),
            _ => {
                return Err(damaged(
                    "there is no chunk here, although the index refers to one".to_owned(),
                ));
            }
        };
        result.map_err(|error| damaged(scan::error_text(&error)))?;
        if let Some(channel) = undefined_channel {
            return Err(damaged(format!(
                "a message is on channel {channel}, which is not defined"
            )));
        }
        self.queued_bytes += messages.iter().map(size).sum::<usize>();
        if self.queued_bytes > MAX_QUEUED_BYTES {
            return Err(damaged(format!(
                "its chunks overlap so much in time that more than {} MB would be in memory at once",
                MAX_QUEUED_BYTES >> 20
            )));
        }
        for message in messages {
            self.count += 1;
            self.queue.insert((message.log_time, self.count), message);
        }
        Ok(())
    }
}

fn open(index: usize, part: &Part) -> Result<(usize, File), ReadError> {
    let file = File::open(&part.path).map_err(failed(&part.path))?;
    Ok((index, file))
}

impl Iterator for Messages {
    type Item = Result<Message, ReadError>;

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
fn size(message: &Message) -> usize {
    size_of::<((u64, u64), Message)>() + message.data.len()
}
