//! Variables imported from other applications. A value arrives with its age, so the clocks need not agree. A
//! value older than its limit is retracted, and so are all values of a peer that is gone. A peer that returns
//! is found again.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, sync_channel};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use jde_app::RemoteVariable as Import;
use jde_board::{Nanos, Writer};
use parking_lot::Mutex;

use super::peer::{self, PeerSearch};
use super::subject::Subject;
use crate::{Error, Sample, ValueBytes};

/// The least time between two values of one import, which bounds the load that a peer can cause.
const MIN_INTERVAL: Duration = Duration::from_millis(1);

/// All imports; dropping them retracts their values.
pub(super) struct Imports {
    state: Arc<ImportState>,
    thread: Option<JoinHandle<()>>,
}

/// The state that the peers' threads share with the writing thread.
pub(super) struct ImportState {
    pub(super) slots: Vec<Slot>,
    pub(super) subject: Arc<dyn Subject>,
    waker: SyncSender<()>,
    stop: AtomicBool,
}

/// An import and its newest message.
pub(super) struct Slot {
    pub(super) import: Import,
    newest: Mutex<Option<ImportUpdate>>,
}

enum ImportUpdate {
    Value { bytes: ValueBytes, time: Nanos },
    Retracted,
}

/// The writing thread's state of an import.
struct ImportWriter {
    writer: Writer,
    /// The time of the current value, if there is one.
    current_time: Option<Nanos>,
    /// Earliest time of the next write.
    next: Instant,
}

impl Imports {
    /// Follows each peer on a thread of its own, and writes the received values.
    pub(super) fn start(subject: &Arc<dyn Subject>, search: &Arc<PeerSearch>) -> Result<Self, Error> {
        let (waker, wakeups) = sync_channel(1);
        let imports = subject.imports();
        let state = Arc::new(ImportState {
            slots: imports
                .iter()
                .map(|import| Slot {
                    import: import.clone(),
                    newest: Mutex::new(None),
                })
                .collect(),
            subject: Arc::clone(subject),
            waker,
            stop: AtomicBool::new(false),
        });
        let mut writers = Vec::new();
        for import in imports {
            writers.push(ImportWriter::open(&**subject, import)?);
        }
        let writer_state = Arc::clone(&state);
        let thread = std::thread::Builder::new()
            .name("link-imports".to_owned())
            .spawn(move || run_writer(&writer_state, writers, &wakeups))
            .map_err(Error::Thread)?;
        let imports = Self {
            state,
            thread: Some(thread),
        };
        let mut peers: BTreeMap<&str, Vec<usize>> = BTreeMap::new();
        for (index, slot) in imports.state.slots.iter().enumerate() {
            peers.entry(&slot.import.peer).or_default().push(index);
        }
        for (name, indices) in peers {
            peer::follow(name, indices, &imports.state, search)?;
        }
        Ok(imports)
    }
}

impl Drop for Imports {
    fn drop(&mut self) {
        self.state.stop.store(true, Ordering::Release);
        self.state.wake();
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

impl ImportState {
    /// Accepts a value. `ratio` is this application's time per time of the peer.
    pub(super) fn receive(&self, index: usize, sample: Sample, ratio: f64) {
        let update = match sample.bytes {
            Some(bytes) => {
                let age = (sample.age as f64 * ratio) as Nanos;
                let time = self.subject.now().saturating_sub(age);
                ImportUpdate::Value { bytes, time }
            }
            None => ImportUpdate::Retracted,
        };
        self.set_newest(index, update);
    }

    /// Retracts the value of an import.
    pub(super) fn retract(&self, index: usize) {
        self.set_newest(index, ImportUpdate::Retracted);
    }

    pub(super) fn is_stopping(&self) -> bool {
        self.stop.load(Ordering::Acquire)
    }

    fn set_newest(&self, index: usize, update: ImportUpdate) {
        let mut newest = self.slots[index].newest.lock();
        *newest = Some(update);
        drop(newest);
        self.wake();
    }

    fn wake(&self) {
        // One pending wake-up is enough.
        let _ = self.waker.try_send(());
    }
}

impl Slot {
    fn take(&self) -> Option<ImportUpdate> {
        self.newest.lock().take()
    }
}

impl ImportWriter {
    fn open(subject: &dyn Subject, import: &Import) -> Result<Self, Error> {
        let opened = subject
            .board()
            .get(&import.local)
            .and_then(|variable| variable.writer(Import::WRITER, "link"));
        Ok(Self {
            writer: opened.map_err(|error| Error::Open(error.to_string()))?,
            current_time: None,
            next: Instant::now(),
        })
    }

    fn write(&mut self, update: ImportUpdate, now: Nanos) {
        match update {
            ImportUpdate::Value { bytes, time } => {
                let value_type = Arc::clone(&self.writer.variable().describe().value_type);
                if value_type.bytes != bytes.len() {
                    // The types were compared before.
                    return;
                }
                value_type.copy_into(&bytes, self.writer.loan());
                self.current_time = self.writer.publish(time, now).is_ok().then_some(time);
            }
            ImportUpdate::Retracted => self.retract(),
        }
    }

    fn retract(&mut self) {
        if self.current_time.take().is_some() {
            self.writer.retract();
        }
    }
}

/// The thread that writes imports. It has the priority of the application's threads, since it also runs the
/// callbacks of waiting readers.
fn run_writer(state: &ImportState, mut writers: Vec<ImportWriter>, wakeups: &Receiver<()>) {
    let speed = state.subject.info().speed.max(f64::MIN_POSITIVE);
    loop {
        let start = Instant::now();
        let mut wake: Option<Instant> = None;
        let mut sooner = |at: Instant| wake = Some(wake.map_or(at, |wake| wake.min(at)));
        for (slot, writer) in state.slots.iter().zip(&mut writers) {
            if start < writer.next {
                sooner(writer.next);
                continue;
            }
            let now = state.subject.now();
            if let Some(update) = slot.take() {
                writer.write(update, now);
                writer.next = start + MIN_INTERVAL;
            }
            if let Some(time) = writer.current_time {
                let expiry = time.saturating_add(slot.import.stale_ns);
                if now > expiry {
                    writer.retract();
                } else {
                    // Application time may run faster or slower than real time.
                    let remaining = (expiry - now) as f64 / speed;
                    sooner(start + Duration::from_nanos(remaining as u64) + MIN_INTERVAL);
                }
            }
        }
        if state.is_stopping() {
            return writers.iter_mut().for_each(ImportWriter::retract);
        }
        let woken = match wake {
            Some(wake) => wakeups.recv_timeout(wake.saturating_duration_since(Instant::now())),
            None => wakeups.recv().map_err(|_| RecvTimeoutError::Disconnected),
        };
        if woken == Err(RecvTimeoutError::Disconnected) {
            return;
        }
    }
}
