//! A stream of this process. One thread writes it and is the only one that waits for its reader. Threads that
//! print queue their lines, and wait no longer than the patience of the process. Lines that find no room in
//! time are dropped, counted and reported.
//!
//! It does not depend on the printed text, and never holds a lock while it writes. It obtains its thread and the
//! room of its queue at its start, and nothing later.

use std::collections::VecDeque;
use std::fs::File;
use std::io::{self, Write};
use std::sync::Arc;
use std::thread::Builder;
use std::time::{Duration, Instant};

use parking_lot::{Condvar, Mutex, MutexGuard};
use rustix::event::{PollFd, PollFlags, poll};

/// Most pieces in the queue: some seconds of the most verbose log.
const MAX_PIECES: usize = 4096;
/// Most bytes in the queue. A single piece may be of any length.
const MAX_BYTES: usize = 4 << 20;
/// Additional room for the messages about dropped lines: one before a gap, one after it.
const NOTICE_ROOM: usize = 2;
/// How long a reader may take nothing before a process that is ending stops waiting for it.
const GRACE_PERIOD: Duration = Duration::from_millis(500);
/// How often a waiting thread checks the patience again.
const POLL_INTERVAL: Duration = Duration::from_millis(50);

/// How long a process waits for the readers of its output.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum BlockingMode {
    /// Until everything is read.
    UntilRead,
    /// Not at all, because a robot moves.
    Never,
    /// As long as readers keep reading, because the process is ending. The time is when that began.
    Brief(Instant),
}

/// The present patience of the process.
pub(super) struct BlockingPolicy(Mutex<BlockingMode>);

impl BlockingPolicy {
    pub(super) const fn new() -> Self {
        Self(Mutex::new(BlockingMode::UntilRead))
    }

    /// Waits for readers until they have read.
    pub(super) fn block(&self) {
        *self.0.lock() = BlockingMode::UntilRead;
    }

    /// Never waits.
    pub(super) fn never_block(&self) {
        *self.0.lock() = BlockingMode::Never;
    }

    /// Waits only as long as readers keep reading.
    pub(super) fn block_briefly(&self) {
        *self.0.lock() = BlockingMode::Brief(Instant::now());
    }

    /// As [`Self::block_briefly`], unless the process does not wait at all or is ending already.
    pub(super) fn finish_soon(&self) {
        let mut patience = self.0.lock();
        if *patience == BlockingMode::UntilRead {
            *patience = BlockingMode::Brief(Instant::now());
        }
    }
}

/// A stream, for use from any thread.
pub(super) struct Stream {
    policy: &'static BlockingPolicy,
    /// Whether dropped lines are reported in the stream itself. They are not where a program reads the lines.
    reports_gaps: bool,
    state: Mutex<StreamState>,
    changed: Condvar,
    /// Notifies the writer.
    filled: Condvar,
}

struct StreamState {
    /// Pieces that the writer has not taken yet.
    pieces: VecDeque<Vec<u8>>,
    /// Pieces that are not written yet, and their bytes.
    queued: usize,
    queued_bytes: usize,
    /// When the reader last took something, or when the queue last became non-empty.
    last_read: Instant,
    /// Lines dropped since the reader fell behind. While it is above 0, only half of `MAX_PIECES` may be in
    /// the queue.
    gap: u64,
    /// Lines dropped in total.
    lost: u64,
    /// The last error of the writer, until it is returned to a caller.
    error: Option<io::Error>,
}

impl Stream {
    /// Creates a stream that writes to a file, pipe or terminal. Its thread ends with the process: `drain` ends in
    /// time, and a join might not.
    ///
    /// # Errors
    /// The system refuses the thread.
    pub(super) fn start(
        name: &str,
        file: File,
        policy: &'static BlockingPolicy,
        reports_gaps: bool,
    ) -> io::Result<Arc<Self>> {
        let stream = Arc::new(Self {
            policy,
            reports_gaps,
            state: Mutex::new(StreamState {
                pieces: VecDeque::with_capacity(MAX_PIECES + NOTICE_ROOM),
                queued: 0,
                queued_bytes: 0,
                last_read: Instant::now(),
                gap: 0,
                lost: 0,
                error: None,
            }),
            changed: Condvar::new(),
            filled: Condvar::new(),
        });
        let written = Arc::clone(&stream);
        let thread = Builder::new().name(name.to_owned());
        thread.spawn(move || written.write_pieces(&file))?;
        Ok(stream)
    }

    /// Queues a piece. It is dropped if there is no room for it within the patience of the process, or at once if the
    /// caller does not wait.
    ///
    /// # Errors
    /// The writer failed since the last call.
    fn put(&self, piece: &[u8], waits: bool) -> io::Result<()> {
        let state = self.state.lock();
        let (mut state, room) = match waits {
            true => self.wait(state, |state| state.has_room(piece.len())),
            false => {
                let room = state.error.is_some() || state.has_room(piece.len());
                (state, room)
            }
        };
        if let Some(error) = state.error.take() {
            return Err(error);
        }
        if !room {
            if state.gap == 0 && self.reports_gaps {
                self.enqueue(
                    &mut state,
                    b"[further lines are dropped: the output is not read]\n",
                );
            }
            state.count_lost(piece);
            return Ok(());
        }
        self.report_gap(&mut state);
        self.enqueue(&mut state, piece);
        Ok(())
    }

    /// Waits until everything is written, for as long as the process has patience.
    ///
    /// # Errors
    /// The writer failed since the last call.
    pub(super) fn drain(&self) -> io::Result<()> {
        let (mut state, _) = self.wait(self.state.lock(), |state| state.queued < MAX_PIECES);
        self.report_gap(&mut state);
        let (mut state, _) = self.wait(state, |state| state.queued == 0);
        state.error.take().map_or(Ok(()), Err)
    }

    /// Whether everything is written.
    pub(super) fn is_idle(&self) -> bool {
        self.state.lock().queued == 0
    }

    /// Returns the number of lines dropped so far.
    pub(super) fn lost(&self) -> u64 {
        self.state.lock().lost
    }

    fn report_gap(&self, state: &mut StreamState) {
        let gap = std::mem::take(&mut state.gap);
        if gap > 0 && self.reports_gaps {
            let lines = if gap == 1 { "line was" } else { "lines were" };
            let notice = format!("[{gap} {lines} dropped here: they were not read in time]\n");
            self.enqueue(state, notice.as_bytes());
        }
    }

    fn enqueue(&self, state: &mut StreamState, piece: &[u8]) {
        if state.queued == 0 {
            state.last_read = Instant::now();
        }
        state.pieces.push_back(piece.to_owned());
        state.queued += 1;
        state.queued_bytes += piece.len();
        self.filled.notify_one();
    }

    /// Writes each piece, on the thread of the stream.
    fn write_pieces(&self, file: &File) {
        let mut state = self.state.lock();
        loop {
            let Some(piece) = state.pieces.pop_front() else {
                self.filled.wait(&mut state);
                continue;
            };
            drop(state);
            let written = self.write(file, &piece);
            state = self.state.lock();
            state.queued -= 1;
            state.queued_bytes -= piece.len();
            if let Err(error) = written {
                state.error = Some(error);
            }
            self.changed.notify_all();
        }
    }

    fn write(&self, mut file: &File, mut rest: &[u8]) -> io::Result<()> {
        while !rest.is_empty() {
            match file.write(rest) {
                Ok(0) => return Err(io::ErrorKind::WriteZero.into()),
                Ok(written) => {
                    rest = &rest[written..];
                    self.state.lock().last_read = Instant::now();
                    self.changed.notify_all();
                }
                Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
                // Another process that shares the stream has made it non-blocking.
                Err(error) if error.kind() == io::ErrorKind::WouldBlock => {
                    // An interrupted wait starts again with the next attempt to write.
                    let _ = poll(&mut [PollFd::new(file, PollFlags::OUT)], None);
                }
                Err(error) => return Err(error),
            }
        }
        Ok(())
    }

    /// Waits until `condition` is true or the writer has failed. Returns false if the patience ended before.
    fn wait<'s>(
        &'s self,
        mut state: MutexGuard<'s, StreamState>,
        condition: impl Fn(&StreamState) -> bool,
    ) -> (MutexGuard<'s, StreamState>, bool) {
        loop {
            if state.error.is_some() || condition(&state) {
                return (state, true);
            }
            let patience = *self.policy.0.lock();
            let remaining = match patience {
                BlockingMode::UntilRead => POLL_INTERVAL,
                BlockingMode::Never => Duration::ZERO,
                BlockingMode::Brief(since) => {
                    GRACE_PERIOD.saturating_sub(state.last_read.max(since).elapsed())
                }
            };
            if remaining.is_zero() {
                return (state, false);
            }
            self.changed.wait_for(&mut state, remaining.min(POLL_INTERVAL));
        }
    }
}

impl StreamState {
    fn has_room(&self, bytes: usize) -> bool {
        let limit = if self.gap > 0 { MAX_PIECES / 2 } else { MAX_PIECES };
        self.queued == 0 || (self.queued < limit && self.queued_bytes + bytes <= MAX_BYTES)
    }

    fn count_lost(&mut self, piece: &[u8]) {
        let lines = piece.iter().filter(|byte| **byte == b'\n').count().max(1) as u64;
        self.gap += lines;
        self.lost += lines;
    }
}

/// Prints lines on a stream. [`Write::flush`] also prints an unfinished line.
pub struct Printer {
    /// `None` before the process has opened its streams: nothing is printed then.
    stream: Option<Arc<Stream>>,
    /// Whether colours are dropped.
    plain: bool,
    /// Whether the calling thread waits for the reader, as long as the process does.
    waits: bool,
    line: Vec<u8>,
}

impl Printer {
    pub(super) fn new(stream: Option<Arc<Stream>>, plain: bool) -> Self {
        Self {
            stream,
            plain,
            waits: true,
            line: Vec::new(),
        }
    }

    /// Never waits for the reader: for threads that others wait for.
    #[must_use]
    pub(super) fn without_waiting(mut self) -> Self {
        self.waits = false;
        self
    }

    /// Whether everything printed on the stream is written.
    pub fn is_idle(&self) -> bool {
        self.stream.as_ref().is_none_or(|stream| stream.is_idle())
    }

    /// Prints an unfinished line, and waits until everything is written for as long as the process has
    /// patience.
    ///
    /// # Errors
    /// Something could not be written.
    pub fn drain(&mut self) -> io::Result<()> {
        self.flush()?;
        self.stream.as_ref().map_or(Ok(()), |stream| stream.drain())
    }

    /// Returns the number of lines dropped on the stream.
    pub fn lost(&self) -> u64 {
        self.stream.as_ref().map_or(0, |stream| stream.lost())
    }

    fn put(&mut self, length: usize) -> io::Result<()> {
        let piece: Vec<u8> = self.line.drain(..length).collect();
        match &self.stream {
            Some(stream) if self.plain => {
                stream.put(&anstream::adapter::strip_bytes(&piece).into_vec(), self.waits)
            }
            Some(stream) => stream.put(&piece, self.waits),
            None => Ok(()),
        }
    }
}

impl Write for Printer {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.line.extend_from_slice(bytes);
        if let Some(end) = bytes.iter().rposition(|byte| *byte == b'\n') {
            let rest = bytes.len() - end - 1;
            self.put(self.line.len() - rest)?;
        }
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        match &self.stream {
            Some(stream) if self.line.is_empty() => stream.state.lock().error.take().map_or(Ok(()), Err),
            _ => self.put(self.line.len()),
        }
    }
}

impl Drop for Printer {
    fn drop(&mut self) {
        // An unfinished line is printed. An error cannot be returned.
        let _ = self.flush();
    }
}

#[cfg(test)]
mod tests;
