//! A stream of this process behind a thread that alone waits for its reader. Whoever prints hands lines over and waits no longer than
//! the process has patience; what is not taken in time is dropped, counted and said.
//!
//! It refuses to know what is printed, and never holds a lock while it writes.

use std::fs::File;
use std::io::{self, Write};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use rustix::event::{PollFd, PollFlags, poll};
use tracing_appender::non_blocking::{NonBlocking, NonBlockingBuilder};

/// Pieces that may wait for the reader: some seconds of the most talkative log.
const MOST_PIECES: usize = 4096;
/// ... and their bytes. One piece may be as long as it likes.
const MOST_BYTES: usize = 4 << 20;
/// What is said of a gap comes on top of what waits.
const SAYING: usize = 8;
/// How long a reader may take nothing before a process that is to end goes without it.
const GRACE: Duration = Duration::from_millis(500);
/// How often whoever waits looks whether it still should.
const LOOK: Duration = Duration::from_millis(50);

/// How long a process waits for those who read what it prints.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Patience {
    /// Until they have read it.
    UntilRead,
    /// Not at all: a robot moves.
    None,
    /// As long as they go on reading: it is to end.
    Brief(Instant),
}

/// What a process has decided about its patience.
pub(super) struct Policy(Mutex<Patience>);

impl Policy {
    pub(super) const fn new() -> Self {
        Self(Mutex::new(Patience::UntilRead))
    }

    /// Waits for readers until they have read.
    pub(super) fn wait(&self) {
        *self.lock() = Patience::UntilRead;
    }

    /// Waits for nobody.
    pub(super) fn wait_for_nobody(&self) {
        *self.lock() = Patience::None;
    }

    /// Waits only as long as readers go on reading.
    pub(super) fn hurry(&self) {
        *self.lock() = Patience::Brief(Instant::now());
    }

    /// As [`Self::hurry`], but for a process that waits for nobody anyway.
    pub(super) fn let_go(&self) {
        let mut patience = self.lock();
        if *patience == Patience::UntilRead {
            *patience = Patience::Brief(Instant::now());
        }
    }

    fn lock(&self) -> MutexGuard<'_, Patience> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// A stream; any thread may print on it.
pub(super) struct Stream {
    policy: &'static Policy,
    /// Whether a gap is told where it is: not among lines that a program reads.
    tells_gaps: bool,
    state: Mutex<State>,
    changed: Condvar,
}

struct State {
    /// The thread that writes; none before it has begun.
    writer: Option<NonBlocking>,
    /// Pieces that are not written yet, and their bytes.
    waiting: usize,
    waiting_bytes: usize,
    /// When the reader took something last, or began to have something to take.
    taken: Instant,
    /// Lines that were dropped since the reader fell behind; more than 0 until there is room for half of what may wait.
    gap: u64,
    /// Lines that were dropped in all.
    lost: u64,
    /// What went wrong, until somebody is told.
    failed: Option<io::Error>,
}

impl Stream {
    /// Writes to a file, pipe or terminal from now on.
    pub(super) fn begin(name: &str, file: File, policy: &'static Policy, tells_gaps: bool) -> Arc<Self> {
        let stream = Arc::new(Self {
            policy,
            tells_gaps,
            state: Mutex::new(State {
                writer: None,
                waiting: 0,
                waiting_bytes: 0,
                taken: Instant::now(),
                gap: 0,
                lost: 0,
                failed: None,
            }),
            changed: Condvar::new(),
        });
        let writer = Writer {
            file,
            stream: Arc::clone(&stream),
        };
        let (writer, guard) = NonBlockingBuilder::default()
            .lossy(true)
            .buffered_lines_limit(MOST_PIECES + SAYING)
            .thread_name(name)
            .finish(writer);
        // Dropped, it would wait for a second and print, whether anybody reads or not; `settle` ends in time instead, and the
        // thread ends with the process.
        std::mem::forget(guard);
        stream.lock().writer = Some(writer);
        stream
    }

    /// Hands a piece over. Dropped if there is no room for it within the patience of the process.
    ///
    /// # Errors
    /// What went wrong since the last call.
    fn put(&self, piece: &[u8]) -> io::Result<()> {
        let (mut state, room) = self.wait(self.lock(), |state| state.has_room(piece.len()));
        if let Some(error) = state.failed.take() {
            return Err(error);
        }
        if !room {
            if state.gap == 0 && self.tells_gaps {
                state.hand_over(b"[lines are dropped from here on: nobody reads them]\n");
            }
            state.lose(piece);
            return Ok(());
        }
        self.tell_gap(&mut state);
        state.hand_over(piece);
        Ok(())
    }

    /// Waits until everything is written, for as long as the process has patience.
    ///
    /// # Errors
    /// What went wrong since the last call.
    pub(super) fn settle(&self) -> io::Result<()> {
        let (mut state, _) = self.wait(self.lock(), |state| state.waiting < MOST_PIECES);
        self.tell_gap(&mut state);
        let (mut state, _) = self.wait(state, |state| state.waiting == 0);
        state.failed.take().map_or(Ok(()), Err)
    }

    /// Whether everything is written.
    pub(super) fn is_idle(&self) -> bool {
        self.lock().waiting == 0
    }

    /// How many lines were dropped so far.
    pub(super) fn lost(&self) -> u64 {
        self.lock().lost
    }

    fn tell_gap(&self, state: &mut State) {
        let gap = std::mem::take(&mut state.gap);
        if gap > 0 && self.tells_gaps {
            let lines = if gap == 1 { "line was" } else { "lines were" };
            state.hand_over(format!("[{gap} {lines} dropped here: nobody read them in time]\n").as_bytes());
        }
    }

    /// Waits until it is so or something failed; answers whether it came to that before the patience ended.
    fn wait<'s>(
        &'s self,
        mut state: MutexGuard<'s, State>,
        so: impl Fn(&State) -> bool,
    ) -> (MutexGuard<'s, State>, bool) {
        loop {
            if state.failed.is_some() || so(&state) {
                return (state, true);
            }
            let patience = *self.policy.lock();
            let left = match patience {
                Patience::UntilRead => LOOK,
                Patience::None => Duration::ZERO,
                Patience::Brief(since) => GRACE.saturating_sub(state.taken.max(since).elapsed()),
            };
            if left.is_zero() {
                return (state, false);
            }
            let waited = self.changed.wait_timeout(state, left.min(LOOK));
            state = waited.unwrap_or_else(PoisonError::into_inner).0;
        }
    }

    fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl State {
    fn has_room(&self, bytes: usize) -> bool {
        let most = if self.gap > 0 {
            MOST_PIECES / 2
        } else {
            MOST_PIECES
        };
        self.waiting == 0 || (self.waiting < most && self.waiting_bytes + bytes <= MOST_BYTES)
    }

    fn hand_over(&mut self, piece: &[u8]) {
        let Some(writer) = &mut self.writer else { return };
        if self.waiting == 0 {
            self.taken = Instant::now();
        }
        let dropped = writer.error_counter().dropped_lines();
        // It never fails: what it has no room for it drops and counts.
        let _ = writer.write_all(piece);
        if writer.error_counter().dropped_lines() > dropped {
            self.lose(piece);
        } else {
            self.waiting += 1;
            self.waiting_bytes += piece.len();
        }
    }

    fn lose(&mut self, piece: &[u8]) {
        let lines = piece.iter().filter(|byte| **byte == b'\n').count().max(1) as u64;
        self.gap += lines;
        self.lost += lines;
    }
}

/// Writes on the thread of a stream.
struct Writer {
    file: File,
    stream: Arc<Stream>,
}

impl Writer {
    fn put(&mut self, mut rest: &[u8]) -> io::Result<()> {
        while !rest.is_empty() {
            match self.file.write(rest) {
                Ok(0) => return Err(io::ErrorKind::WriteZero.into()),
                Ok(written) => {
                    rest = &rest[written..];
                    self.stream.lock().taken = Instant::now();
                    self.stream.changed.notify_all();
                }
                Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
                // Whoever shares the stream with us wants it so.
                Err(error) if error.kind() == io::ErrorKind::WouldBlock => {
                    // An interrupted wait is begun again by the next attempt to write.
                    let _ = poll(&mut [PollFd::new(&self.file, PollFlags::OUT)], None);
                }
                Err(error) => return Err(error),
            }
        }
        Ok(())
    }
}

impl Write for Writer {
    fn write(&mut self, piece: &[u8]) -> io::Result<usize> {
        let written = self.put(piece);
        let mut state = self.stream.lock();
        state.waiting -= 1;
        state.waiting_bytes -= piece.len();
        if let Err(error) = written {
            state.failed = Some(error);
        }
        drop(state);
        self.stream.changed.notify_all();
        Ok(piece.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

/// Prints lines on a stream; what is no whole line yet goes with [`Write::flush`].
pub(crate) struct Printer {
    stream: Arc<Stream>,
    /// Whether colours are left out.
    plain: bool,
    line: Vec<u8>,
}

impl Printer {
    pub(super) fn new(stream: Arc<Stream>, plain: bool) -> Self {
        Self {
            stream,
            plain,
            line: Vec::new(),
        }
    }

    /// Whether everything that was printed on the stream is written.
    pub(crate) fn is_idle(&self) -> bool {
        self.stream.is_idle()
    }

    /// Prints what is no whole line, and waits until everything is written for as long as the process has patience.
    ///
    /// # Errors
    /// Something could not be written.
    pub(crate) fn settle(&mut self) -> io::Result<()> {
        self.flush()?;
        self.stream.settle()
    }

    /// How many lines were dropped on the stream.
    pub(crate) fn lost(&self) -> u64 {
        self.stream.lost()
    }

    fn put(&mut self, length: usize) -> io::Result<()> {
        let piece: Vec<u8> = self.line.drain(..length).collect();
        if self.plain {
            self.stream
                .put(&anstream::adapter::strip_bytes(&piece).into_vec())
        } else {
            self.stream.put(&piece)
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
        if self.line.is_empty() {
            return self.stream.lock().failed.take().map_or(Ok(()), Err);
        }
        self.put(self.line.len())
    }
}

impl Drop for Printer {
    fn drop(&mut self) {
        // What has been put into words is shown; nobody is left to hear that it cannot be.
        let _ = self.flush();
    }
}

#[cfg(test)]
mod tests;
