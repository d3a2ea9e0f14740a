//! Variables of other applications, kept up to date here. A value comes with its age, so no two clocks need agree; one that is
//! older than its limit is taken back, and so is all that comes from a peer that is gone. Who comes back is found again.

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

/// The least time between two values of one import: whatever a peer sends, the rest of the application hears no more.
const LEAST: Duration = Duration::from_millis(1);

/// All imports; dropped, they are taken back.
pub(super) struct Imports {
    inner: Arc<Inner>,
    thread: Option<JoinHandle<()>>,
}

/// What threads of peers and the writing thread share.
pub(super) struct Inner {
    pub(super) slots: Vec<Slot>,
    pub(super) subject: Arc<dyn Subject>,
    ring: SyncSender<()>,
    stop: AtomicBool,
}

/// An import and what came for it last.
pub(super) struct Slot {
    pub(super) import: Import,
    newest: Mutex<Option<News>>,
}

enum News {
    Value { bytes: Vec<u8>, time: Nanos },
    Gone,
}

/// What the writing thread has of an import.
struct Kept {
    writer: Writer,
    /// When the value that is there was measured.
    shown: Option<Nanos>,
    /// When the next may be written.
    next: Instant,
}

impl Imports {
    /// Looks for all peers, each on a thread of its own, and writes what they send.
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
    /// A value came; `ratio` is how fast time goes here for each second of the peer's.
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

    /// Nothing of it counts any more.
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
        // One that waits to be heard is enough.
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

/// The one thread that writes imports: as urgent as the application's own, since whoever waits for a value is called by it.
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
                    // The time of the application may go faster or slower than that of the machine.
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
