//! The way of values from whoever publishes them to the thread that writes: preallocated slots that go round, full and empty.
//! Nobody allocates, and nobody who publishes in real time ever waits.

use std::collections::BTreeMap;
use std::sync::atomic::{AtomicBool, AtomicU64, AtomicUsize, Ordering};
use std::sync::mpsc::{SyncSender, TrySendError};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, OnceLock, PoisonError};
use std::thread::Thread;
use std::time::Duration;

use crossbeam_queue::ArrayQueue;
use jde_abi::describe::Type;
use jde_board::{Nanos, Variable};
use jde_host::event::Event;
use jde_host::story::Line;
use jde_panel::List;

use crate::panel;
use crate::recorder::{Clock, Parts, Written};
use crate::tap::retracted;

/// Bytes of slots that a topic gets: a laser of 1088 beams at 40 Hz outlives a disk that stands still for more than a second.
const ROOM: usize = 512 << 10;
/// Slots of a panel: half a second of one that is drawn as fast as can be.
const PANELS: usize = 16;
/// Most bytes of a panel's drawings on their way: some seconds of one with a picture in it, or one of the largest.
const PANEL_BYTES: usize = 16 << 20;
/// Even the largest get so many slots, the smallest no more than that.
const SLOTS: (usize, usize) = (4, 1024);
/// How long a lossless writer waits before it looks again by itself.
const LOOK_AGAIN: Duration = Duration::from_millis(10);

/// When a value was made, and which of its topic it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Stamps {
    /// When it was published, ns of the application's clock: the order of messages in the recording.
    pub published: Nanos,
    /// When it was measured.
    pub measured: Nanos,
    /// Counts the values of the topic; a gap is a value that was lost.
    pub sequence: u64,
}

/// A topic of a recording, to be written by anybody: variables of an application, or values that come from elsewhere.
#[derive(Clone)]
pub struct Topic {
    pub(crate) lane: Arc<Lane>,
    pub(crate) shared: Arc<Shared>,
}

/// A value on its way.
pub(crate) struct Slot {
    /// Its place in the order of all that is put and told.
    pub(crate) order: u64,
    pub(crate) stamps: Stamps,
    pub(crate) form: SlotForm,
    pub(crate) bytes: Vec<u8>,
}

/// What the bytes of a slot are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum SlotForm {
    /// A value, as its type says.
    Value,
    /// A message as it is to be written.
    Message,
}

/// What goes through a lane.
#[derive(Clone)]
pub(crate) enum Holds {
    /// Values of a type.
    Values(Arc<Type>),
    /// What a panel showed.
    Panel,
}

/// The two queues of a topic.
pub(crate) struct Lane {
    pub(crate) name: String,
    pub(crate) holds: Holds,
    pub(crate) about: BTreeMap<String, String>,
    pub(crate) free: ArrayQueue<Box<Slot>>,
    pub(crate) full: ArrayQueue<Box<Slot>>,
    /// Bytes on their way, of a panel: values have as many as their slots.
    flying: AtomicUsize,
    /// Set for values that are too large to be copied by whoever publishes them.
    pub(crate) note: Option<Note>,
    /// Whether it goes into files; if not, conditions look at it and that is all.
    pub(crate) kept: bool,
    pub(crate) lost: AtomicU64,
}

/// That there is something to be fetched.
pub(crate) struct Note {
    pub(crate) variable: Arc<Variable>,
    /// Number of its newest value when it was first watched.
    pub(crate) since: u64,
    pub(crate) new: AtomicBool,
    pub(crate) published: AtomicU64,
}

/// What the writing thread is told besides values.
pub(crate) enum Told {
    /// Something happened.
    Event(Event),
    /// Something happened elsewhere.
    Line(Line),
    /// Something that had happened there before this time, at which the recording began.
    Earlier(Line, Nanos),
    /// The value of a variable was taken back.
    Retracted {
        /// When.
        time: Nanos,
        /// Which, by its full name.
        variable: String,
    },
}

/// What publishers and the writing thread share.
pub(crate) struct Shared {
    pub(crate) lanes: Mutex<Vec<Arc<Lane>>>,
    tell: SyncSender<(u64, Told)>,
    /// Counts what is put and told.
    order: AtomicU64,
    /// Whoever publishes waits rather than lose anything.
    pub(crate) lossless: bool,
    pub(crate) closed: AtomicBool,
    pub(crate) scribe: OnceLock<Thread>,
    pub(crate) lost_events: AtomicU64,
    pub(crate) kept: AtomicU64,
    pub(crate) dropped: AtomicU64,
    pub(crate) bytes: AtomicU64,
    /// Messages that left the ring before their time was up.
    pub(crate) short: AtomicU64,
    pub(crate) trouble: Mutex<Option<String>>,
    pub(crate) files: Mutex<Vec<Written>>,
    pub(crate) parts: Mutex<Parts>,
    /// The application's clock, once somebody has brought it.
    pub(crate) clock: OnceLock<Clock>,
    waiting: Mutex<()>,
    roomy: Condvar,
}

impl Lane {
    pub(crate) fn new(
        name: String,
        holds: Holds,
        about: BTreeMap<String, String>,
        note: Option<Note>,
        kept: bool,
    ) -> Self {
        let bytes = match &holds {
            Holds::Values(value_type) => value_type.bytes,
            // They grow as large as the panels are.
            Holds::Panel => 0,
        };
        let slots = match (&holds, &note) {
            (_, Some(_)) => 1,
            (Holds::Values(_), None) => (ROOM / bytes).clamp(SLOTS.0, SLOTS.1),
            (Holds::Panel, None) => PANELS,
        };
        let free = ArrayQueue::new(slots);
        if note.is_none() {
            for _ in 0..slots {
                let slot = Slot {
                    order: 0,
                    stamps: Stamps {
                        published: 0,
                        measured: 0,
                        sequence: 0,
                    },
                    form: SlotForm::Value,
                    bytes: vec![0; bytes],
                };
                // As many as there is room for.
                let _ = free.push(Box::new(slot));
            }
        }
        Self {
            name,
            holds,
            about,
            free,
            full: ArrayQueue::new(slots),
            flying: AtomicUsize::new(0),
            note,
            kept,
            lost: AtomicU64::new(0),
        }
    }

    /// Takes back a slot that has been written. One that a large drawing has grown shrinks again.
    pub(crate) fn give_back(&self, mut slot: Box<Slot>) {
        self.land(slot.bytes.len());
        if matches!(self.holds, Holds::Panel) && slot.bytes.capacity() > ROOM {
            slot.bytes = Vec::new();
        }
        // It came from there.
        let _ = self.free.push(slot);
    }

    /// Counts bytes that are to go; answers whether there is room. One drawing may always go, however large.
    fn fly(&self, bytes: usize) -> bool {
        if !matches!(self.holds, Holds::Panel) {
            return true;
        }
        let before = self.flying.fetch_add(bytes, Ordering::Relaxed);
        before == 0 || before + bytes <= PANEL_BYTES
    }

    fn land(&self, bytes: usize) {
        if matches!(self.holds, Holds::Panel) {
            self.flying.fetch_sub(bytes, Ordering::Relaxed);
        }
    }
}

impl Topic {
    /// Keeps a value of this topic; answers whether there was room. Never waits and never allocates, except that a lossless
    /// recording has the caller wait for room. Any thread may call it. Lost values are counted.
    ///
    /// # Panics
    /// If there are not as many bytes as the type has, or it is the topic of a panel.
    pub fn put(&self, bytes: &[u8], stamps: Stamps) -> bool {
        let Holds::Values(value_type) = &self.lane.holds else {
            panic!("a panel has no values");
        };
        assert_eq!(bytes.len(), value_type.bytes, "a value of {}", self.lane.name);
        self.fill(bytes, SlotForm::Value, stamps)
    }

    /// Keeps a value that is a message already: CDR, little endian, with its header. Like [`Self::put`], but may allocate the
    /// first few times. What is in it is not looked at; `jde_ros::cdr::decode` says whether it is of the type.
    pub fn put_message(&self, message: &[u8], stamps: Stamps) -> bool {
        self.fill(message, SlotForm::Message, stamps)
    }

    /// Keeps what a panel showed, or why it showed nothing. It may allocate.
    pub fn put_panel(&self, shown: &Result<List, String>, stamps: Stamps) -> bool {
        self.fill(&panel::message(shown), SlotForm::Message, stamps)
    }

    fn fill(&self, bytes: &[u8], form: SlotForm, stamps: Stamps) -> bool {
        if self.shared.closed.load(Ordering::Acquire) {
            return false;
        }
        let lane = &*self.lane;
        // Who waits rather than lose anything is bounded by the slots.
        let fits = lane.fly(bytes.len()) || self.shared.lossless;
        let slot = fits.then(|| lane.free.pop().or_else(|| self.shared.wait_for_room(lane)));
        let Some(mut slot) = slot.flatten() else {
            lane.land(bytes.len());
            lane.lost.fetch_add(1, Ordering::Relaxed);
            return false;
        };
        slot.order = self.shared.next();
        (slot.stamps, slot.form) = (stamps, form);
        slot.bytes.clear();
        slot.bytes.extend_from_slice(bytes);
        // There are no more slots than there is room.
        let _ = lane.full.push(slot);
        if lane.free.len() < lane.free.capacity() / 4 {
            self.shared.wake();
        }
        true
    }

    /// The value was taken back at this time, ns of the application's clock: there is none until the next.
    pub fn retract(&self, time: Nanos) {
        self.shared.tell(retracted(time, &self.lane));
    }

    /// Counts values that are known to have been lost on the way here.
    pub fn lose(&self, count: u64) {
        self.lane.lost.fetch_add(count, Ordering::Relaxed);
    }
}

impl Shared {
    pub(crate) fn new(tell: SyncSender<(u64, Told)>, lossless: bool) -> Self {
        Self {
            lanes: Mutex::default(),
            tell,
            order: AtomicU64::new(0),
            lossless,
            closed: AtomicBool::new(false),
            scribe: OnceLock::new(),
            lost_events: AtomicU64::new(0),
            kept: AtomicU64::new(0),
            dropped: AtomicU64::new(0),
            bytes: AtomicU64::new(0),
            short: AtomicU64::new(0),
            trouble: Mutex::default(),
            files: Mutex::default(),
            parts: Mutex::default(),
            clock: OnceLock::new(),
            waiting: Mutex::new(()),
            roomy: Condvar::new(),
        }
    }

    /// Tells the writing thread of something; what it has no room for is counted.
    pub(crate) fn tell(&self, told: Told) {
        if self.closed.load(Ordering::Acquire) {
            return;
        }
        match self.tell.try_send((self.next(), told)) {
            Ok(()) => {}
            Err(TrySendError::Full(told)) if self.lossless => {
                self.wake();
                // Nobody listens any more once it is closed.
                let _ = self.tell.send(told);
            }
            Err(TrySendError::Full(_)) => {
                self.lost_events.fetch_add(1, Ordering::Relaxed);
            }
            Err(TrySendError::Disconnected(_)) => {}
        }
    }

    /// The number of what is put or told next.
    fn next(&self) -> u64 {
        self.order.fetch_add(1, Ordering::AcqRel)
    }

    /// All numbers below this one are given. If one thread puts and tells everything, all but the last of these are there.
    pub(crate) fn given(&self) -> u64 {
        self.order.load(Ordering::Acquire)
    }

    /// Values that were lost on the way here, by topic.
    pub(crate) fn lost_of(&self) -> BTreeMap<String, u64> {
        let lanes = lock(&self.lanes);
        lanes
            .iter()
            .filter(|lane| lane.kept)
            .map(|lane| (lane.name.clone(), lane.lost.load(Ordering::Relaxed)))
            .filter(|(_, lost)| *lost > 0)
            .collect()
    }

    pub(crate) fn wake(&self) {
        if let Some(scribe) = self.scribe.get() {
            scribe.unpark();
        }
    }

    /// The writing thread has emptied slots.
    pub(crate) fn made_room(&self) {
        if self.lossless {
            drop(lock(&self.waiting));
            self.roomy.notify_all();
        }
    }

    fn wait_for_room(&self, lane: &Lane) -> Option<Box<Slot>> {
        let mut waiting = self.lossless.then(|| lock(&self.waiting))?;
        loop {
            if let Some(slot) = lane.free.pop() {
                return Some(slot);
            }
            if self.closed.load(Ordering::Acquire) {
                return None;
            }
            self.wake();
            waiting = self
                .roomy
                .wait_timeout(waiting, LOOK_AGAIN)
                .map_or_else(|poisoned| poisoned.into_inner().0, |(guard, _)| guard);
        }
    }
}

pub(crate) fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests {
    use std::sync::mpsc::sync_channel;

    use super::*;

    #[test]
    fn the_drawings_of_a_panel_are_bounded_in_bytes_and_leave_no_large_slots() {
        let (tell, _told) = sync_channel(1);
        let lane = Lane::new(
            "/panels/goon".to_owned(),
            Holds::Panel,
            BTreeMap::new(),
            None,
            true,
        );
        let topic = Topic {
            lane: Arc::new(lane),
            shared: Arc::new(Shared::new(tell, false)),
        };
        let stamps = Stamps {
            published: 0,
            measured: 0,
            sequence: 0,
        };
        let put = |bytes: usize| topic.put_message(&vec![0; bytes], stamps);
        let write = || {
            topic
                .lane
                .give_back(topic.lane.full.pop().expect("one is on its way"))
        };
        assert!(put(2 * PANEL_BYTES), "one may always go");
        assert!(!put(1), "and nothing beside it");
        write();
        assert!(put(PANEL_BYTES / 2) && put(PANEL_BYTES / 2));
        assert!(!put(1));
        write();
        assert!(put(1));
        assert_eq!(topic.lane.lost.load(Ordering::Relaxed), 2);
        write();
        write();
        let slots = std::iter::from_fn(|| topic.lane.free.pop());
        assert!(slots.fold(0, |largest, slot| largest.max(slot.bytes.capacity())) <= ROOM);
    }
}
