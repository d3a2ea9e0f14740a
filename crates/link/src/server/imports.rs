//! Variables imported from other applications. A value arrives with its age, so the clocks need not agree. A
//! value older than its limit is retracted, and so are all values of a peer that is gone. A peer that returns
//! is found again.

use std::collections::BTreeMap;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, sync_channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use jde_board::{Nanos, Writer};
use jde_host::app::Remote as Import;

use super::peer::{self, Search};
use super::subject::Subject;
use crate::{Error, Sample};

/// The least time between two values of one import, which bounds the load that a peer can cause.
const LEAST: Duration = Duration::from_millis(1);

/// All imports; dropping them retracts their values.
pub(super) struct Imports {
    inner: Arc<Inner>,
    thread: Option<JoinHandle<()>>,
}

/// The state that the peers' threads share with the writing thread.
pub(super) struct Inner {
    pub(super) slots: Vec<Slot>,
    pub(super) subject: Arc<dyn Subject>,
    ring: SyncSender<()>,
    stop: AtomicBool,
}

/// An import and its newest message.
pub(super) struct Slot {
    pub(super) import: Import,
    newest: Mutex<Option<News>>,
}

enum News {
    Value { bytes: Vec<u8>, time: Nanos },
    Gone,
}

/// The writing thread's state of an import.
struct Kept {
    writer: Writer,
    /// The time of the current value, if there is one.
    shown: Option<Nanos>,
    /// Earliest time of the next write.
    next: Instant,
}

impl Imports {
    /// Follows each peer on a thread of its own, and writes the received values.
    pub(super) fn start(subject: &Arc<dyn Subject>, search: &Arc<Search>) -> Result<Self, Error> {
        let (ring, rung) = sync_channel(1);
        let imports = subject.imports();
        let inner = Arc::new(Inner {
            slots: imports
                .iter()
                .map(|import| Slot {
                    import: import.clone(),
                    newest: Mutex::new(None),
                })
                .collect(),
            subject: Arc::clone(subject),
            ring,
            stop: AtomicBool::new(false),
        });
        let mut kept = Vec::new();
        for import in imports {
            kept.push(Kept::open(&**subject, import)?);
        }
        let writing = Arc::clone(&inner);
        let thread = std::thread::Builder::new()
            .name("link-imports".to_owned())
            .spawn(move || write(&writing, kept, &rung))
            .map_err(Error::Thread)?;
        let imports = Self {
            inner,
            thread: Some(thread),
        };
        let mut peers: BTreeMap<&str, Vec<usize>> = BTreeMap::new();
        for (place, slot) in imports.inner.slots.iter().enumerate() {
            peers.entry(&slot.import.peer).or_default().push(place);
        }
        for (name, places) in peers {
            peer::follow(name, places, &imports.inner, search)?;
        }
        Ok(imports)
    }
}

impl Drop for Imports {
    fn drop(&mut self) {
        self.inner.stop.store(true, Ordering::Release);
        self.inner.ring();
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

impl Inner {
    /// Accepts a value. `ratio` is application time here per application time of the peer.
    pub(super) fn came(&self, place: usize, sample: Sample, ratio: f64) {
        let news = match sample.bytes {
            Some(bytes) => {
                let age = (sample.age as f64 * ratio) as Nanos;
                let time = self.subject.now().saturating_sub(age);
                News::Value { bytes, time }
            }
            None => News::Gone,
        };
        self.tell(place, news);
    }

    /// Retracts the value of an import.
    pub(super) fn gone(&self, place: usize) {
        self.tell(place, News::Gone);
    }

    pub(super) fn stopping(&self) -> bool {
        self.stop.load(Ordering::Acquire)
    }

    fn tell(&self, place: usize, news: News) {
        let mut newest = self.slots[place]
            .newest
            .lock()
            .unwrap_or_else(PoisonError::into_inner);
        *newest = Some(news);
        drop(newest);
        self.ring();
    }

    fn ring(&self) {
        // One pending wake-up is enough.
        let _ = self.ring.try_send(());
    }
}

impl Slot {
    fn take(&self) -> Option<News> {
        self.newest.lock().unwrap_or_else(PoisonError::into_inner).take()
    }
}

impl Kept {
    fn open(subject: &dyn Subject, import: &Import) -> Result<Self, Error> {
        let opened = subject
            .board()
            .get(&import.local)
            .and_then(|variable| variable.writer(Import::WRITER, "link"));
        Ok(Self {
            writer: opened.map_err(|error| Error::Open(error.to_string()))?,
            shown: None,
            next: Instant::now(),
        })
    }

    fn write(&mut self, news: News, now: Nanos) {
        match news {
            News::Value { bytes, time } => {
                let room = self.writer.loan();
                if room.len() != bytes.len() {
                    // The types were compared before.
                    self.writer.discard();
                    return;
                }
                room.copy_from_slice(&bytes);
                self.shown = self.writer.publish(time, now).is_ok().then_some(time);
            }
            News::Gone => self.take_back(),
        }
    }

    fn take_back(&mut self) {
        if self.shown.take().is_some() {
            self.writer.retract();
        }
    }
}

/// The thread that writes imports. It has the priority of the application's threads, since it also runs the
/// callbacks of waiting readers.
fn write(inner: &Inner, mut kept: Vec<Kept>, rung: &Receiver<()>) {
    let speed = inner.subject.title().speed.max(f64::MIN_POSITIVE);
    loop {
        let start = Instant::now();
        let mut wake: Option<Instant> = None;
        let mut sooner = |at: Instant| wake = Some(wake.map_or(at, |wake| wake.min(at)));
        for (slot, kept) in inner.slots.iter().zip(&mut kept) {
            if start < kept.next {
                sooner(kept.next);
                continue;
            }
            let now = inner.subject.now();
            if let Some(news) = slot.take() {
                kept.write(news, now);
                kept.next = start + LEAST;
            }
            if let Some(time) = kept.shown {
                let over = time.saturating_add(slot.import.stale_ns);
                if now > over {
                    kept.take_back();
                } else {
                    // Application time may run faster or slower than real time.
                    let left = (over - now) as f64 / speed;
                    sooner(start + Duration::from_nanos(left as u64) + LEAST);
                }
            }
        }
        if inner.stopping() {
            return kept.iter_mut().for_each(Kept::take_back);
        }
        let heard = match wake {
            Some(wake) => rung.recv_timeout(wake.saturating_duration_since(Instant::now())),
            None => rung.recv().map_err(|_| RecvTimeoutError::Disconnected),
        };
        if heard == Err(RecvTimeoutError::Disconnected) {
            return;
        }
    }
}
