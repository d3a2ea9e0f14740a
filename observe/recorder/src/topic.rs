//! The path of values from their publishers to the writing thread: preallocated slots that circulate between
//! a queue of full ones and a queue of empty ones. Publishing a value allocates nothing, and never waits in
//! real time.

use std::collections::BTreeMap;
use std::sync::atomic::{AtomicBool, AtomicU64, AtomicUsize, Ordering};
use std::sync::mpsc::{SyncSender, TrySendError};
use std::sync::{Arc, OnceLock};
use std::thread::Thread;
use std::time::Duration;

use crossbeam_queue::ArrayQueue;
use jde_abi::describe::Type;
use jde_board::{Nanos, Variable};
use jde_log::{log_line, panel};
use jde_panel::List;
use jde_records::RunRecord;
use jde_records::event::Event;
use parking_lot::{Condvar, Mutex};

use crate::recorder::{Clock, Parts, TriggeredFile};
use crate::subscriber::retraction_notice;

/// Bytes of the slots of one topic. With it, no value of a laser of 1088 beams at 40 Hz is lost while a disk
/// blocks for more than a second.
const TOPIC_BYTES: usize = 512 << 10;
/// Slots of a panel: half a second of one that is drawn at the highest rate.
const PANEL_SLOTS: usize = 16;
/// Slots of a log: what all schemas print at once when the robot starts.
const LOG_SLOTS: usize = 1024;
/// Upper limit of the bytes of a panel's drawings, or of a log's lines, that are not yet written: some seconds of one that contains
/// a picture, or one of the largest.
const PANEL_BYTES: usize = 16 << 20;
/// The fewest slots, for the largest values, and the most, for the smallest.
const SLOTS: (usize, usize) = (4, 1024);
/// How long a lossless publisher waits before it checks for an empty slot without a notification.
const ROOM_TIMEOUT: Duration = Duration::from_millis(10);

/// The times of a value, and its number within the topic.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Stamps {
    /// The time of publication, in ns of the application's clock. It determines the order of messages in the
    /// recording.
    pub published: Nanos,
    /// The time of measurement, in ns of the same clock.
    pub measured: Nanos,
    /// The number of the value within the topic. A gap means that a value was lost.
    pub sequence: u64,
}

/// A topic of a recording. Any thread may write it: for variables of an application, or for values of
/// another process.
#[derive(Clone)]
pub struct Topic {
    pub(crate) queue: Arc<TopicQueue>,
    pub(crate) shared: Arc<Shared>,
}

/// A value that is not yet written.
pub(crate) struct Slot {
    /// Its position in the order of all values and notices.
    pub(crate) order: u64,
    pub(crate) stamps: Stamps,
    pub(crate) form: SlotForm,
    pub(crate) bytes: Vec<u8>,
}

/// The format of a slot's bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum SlotForm {
    /// A value in the layout of its type.
    Value,
    /// An encoded message, written without change.
    Message,
}

/// The contents of a topic.
#[derive(Clone)]
pub(crate) enum TopicContent {
    /// Values of a type.
    Values(Arc<Type>),
    /// Messages of any length: the drawings of a panel, or the lines of a log.
    Messages {
        /// The name of their type, and its definition.
        schema: (&'static str, &'static str),
        /// The most that are not yet written.
        slots: usize,
    },
}

impl TopicContent {
    pub(crate) const PANEL: Self = Self::Messages {
        schema: (panel::TYPE, panel::DEFINITION),
        slots: PANEL_SLOTS,
    };
    pub(crate) const LOG: Self = Self::Messages {
        schema: (log_line::TYPE, log_line::DEFINITION),
        slots: LOG_SLOTS,
    };
}

/// The two queues of a topic.
pub(crate) struct TopicQueue {
    pub(crate) name: String,
    pub(crate) content: TopicContent,
    pub(crate) metadata: BTreeMap<String, String>,
    pub(crate) free: ArrayQueue<Box<Slot>>,
    pub(crate) full: ArrayQueue<Box<Slot>>,
    /// Bytes of messages that are not yet written. Values need no such limit: their slots limit them.
    pending_bytes: AtomicUsize,
    /// Set for values that are too large to be copied by their publisher. The writing thread then fetches the
    /// value.
    pub(crate) fetch_flag: Option<FetchFlag>,
    /// Whether the values are written to files. If not, only conditions read them.
    pub(crate) is_recorded: bool,
    pub(crate) lost: AtomicU64,
}

/// Marks that a new value can be fetched.
pub(crate) struct FetchFlag {
    pub(crate) variable: Arc<Variable>,
    /// The number of the variable's newest value when the watch started.
    pub(crate) first: u64,
    pub(crate) is_new: AtomicBool,
    pub(crate) published: AtomicU64,
}

/// A notice to the writing thread: everything except values.
pub(crate) enum Notice {
    /// An event of the application.
    Event(Event),
    /// A record of an application in another process.
    Record(RunRecord),
    /// A record of another process from before this time, at which the recording began.
    EarlierRecord(RunRecord, Nanos),
    /// The value of a variable was retracted.
    Retracted {
        /// The time of the retraction.
        time: Nanos,
        /// The full name of the variable.
        variable: String,
    },
}

/// The state that publishers and the writing thread share.
pub(crate) struct Shared {
    pub(crate) topics: Mutex<Vec<Arc<TopicQueue>>>,
    notices: SyncSender<(u64, Notice)>,
    /// Counts the values and notices.
    order: AtomicU64,
    /// Whether publishers wait instead of losing values.
    pub(crate) lossless: bool,
    pub(crate) closed: AtomicBool,
    pub(crate) writer_thread: OnceLock<Thread>,
    pub(crate) lost_events: AtomicU64,
    pub(crate) written: AtomicU64,
    pub(crate) dropped: AtomicU64,
    pub(crate) bytes: AtomicU64,
    /// Messages that were removed from the buffer before their time ended.
    pub(crate) evicted: AtomicU64,
    pub(crate) error: Mutex<Option<String>>,
    pub(crate) files: Mutex<Vec<TriggeredFile>>,
    pub(crate) parts: Mutex<Parts>,
    /// The application's clock, once it has been provided.
    pub(crate) clock: OnceLock<Clock>,
    room_lock: Mutex<()>,
    room_condvar: Condvar,
}

impl TopicQueue {
    pub(crate) fn new(
        name: String,
        content: TopicContent,
        metadata: BTreeMap<String, String>,
        fetch_flag: Option<FetchFlag>,
        is_recorded: bool,
    ) -> Self {
        let bytes = match &content {
            TopicContent::Values(value_type) => value_type.bytes,
            // These slots grow as needed.
            TopicContent::Messages { .. } => 0,
        };
        let slots = match (&content, &fetch_flag) {
            (_, Some(_)) => 1,
            (TopicContent::Values(_), None) => (TOPIC_BYTES / bytes).clamp(SLOTS.0, SLOTS.1),
            (TopicContent::Messages { slots, .. }, None) => *slots,
        };
        let free = ArrayQueue::new(slots);
        if fetch_flag.is_none() {
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
                // There are exactly as many slots as the queue can hold.
                let _ = free.push(Box::new(slot));
            }
        }
        Self {
            name,
            content,
            metadata,
            free,
            full: ArrayQueue::new(slots),
            pending_bytes: AtomicUsize::new(0),
            fetch_flag,
            is_recorded,
            lost: AtomicU64::new(0),
        }
    }

    /// Returns a written slot to the empty ones. A slot that a large drawing has enlarged is shrunk.
    pub(crate) fn recycle(&self, mut slot: Box<Slot>) {
        self.release_bytes(slot.bytes.len());
        if matches!(self.content, TopicContent::Messages { .. }) && slot.bytes.capacity() > TOPIC_BYTES {
            slot.bytes = Vec::new();
        }
        // The slot was taken from this queue, so there is room.
        let _ = self.free.push(slot);
    }

    /// Counts bytes that wait to be written. Returns whether they fit. A single drawing always fits, whatever
    /// its size.
    fn reserve_bytes(&self, bytes: usize) -> bool {
        if !matches!(self.content, TopicContent::Messages { .. }) {
            return true;
        }
        let before = self.pending_bytes.fetch_add(bytes, Ordering::Relaxed);
        before == 0 || before + bytes <= PANEL_BYTES
    }

    fn release_bytes(&self, bytes: usize) {
        if matches!(self.content, TopicContent::Messages { .. }) {
            self.pending_bytes.fetch_sub(bytes, Ordering::Relaxed);
        }
    }
}

impl Topic {
    /// Records a value of this topic. Returns whether there was room. It never waits and never allocates,
    /// except that in a lossless recording the caller waits for room. Any thread may call it. Lost values are
    /// counted.
    ///
    /// # Panics
    /// If the number of bytes is not that of the type, or if the topic is one of messages.
    pub fn put(&self, bytes: &[u8], stamps: Stamps) -> bool {
        let TopicContent::Values(value_type) = &self.queue.content else {
            panic!("a topic of messages has no values");
        };
        assert_eq!(bytes.len(), value_type.bytes, "a value of {}", self.queue.name);
        self.fill(bytes.len(), SlotForm::Value, stamps, |slot| {
            slot.resize(bytes.len(), 0);
            value_type.copy_into(bytes, slot);
        })
    }

    /// Records an encoded message: CDR, little endian, with its header. Like [`Self::put`], but the first few
    /// calls may allocate. The contents are not checked; `jde_ros::cdr::decode` checks them against the type.
    pub fn put_message(&self, message: &[u8], stamps: Stamps) -> bool {
        self.fill(message.len(), SlotForm::Message, stamps, |slot| {
            slot.clear();
            slot.extend_from_slice(message);
        })
    }

    /// Records the drawing of a panel, or the reason why there is none. It may allocate.
    pub fn put_panel(&self, shown: &Result<List, String>, stamps: Stamps) -> bool {
        self.put_message(&panel::message(shown), stamps)
    }

    /// Lets `write` fill an empty slot with this many bytes.
    fn fill(&self, bytes: usize, form: SlotForm, stamps: Stamps, write: impl FnOnce(&mut Vec<u8>)) -> bool {
        if self.shared.closed.load(Ordering::Acquire) {
            return false;
        }
        let queue = &*self.queue;
        // For publishers that wait instead of losing values, the number of slots is the limit.
        let fits = queue.reserve_bytes(bytes) || self.shared.lossless;
        let slot = fits.then(|| queue.free.pop().or_else(|| self.shared.wait_for_room(queue)));
        let Some(mut slot) = slot.flatten() else {
            queue.release_bytes(bytes);
            queue.lost.fetch_add(1, Ordering::Relaxed);
            return false;
        };
        slot.order = self.shared.assign_order();
        (slot.stamps, slot.form) = (stamps, form);
        write(&mut slot.bytes);
        // There are no more slots than the queue can hold.
        let _ = queue.full.push(slot);
        if queue.free.len() < queue.free.capacity() / 4 {
            self.shared.wake();
        }
        true
    }

    /// Records that the value was retracted at this time, in ns of the application's clock. There is no value
    /// until the next one.
    pub fn retract(&self, time: Nanos) {
        self.shared.push_notice(retraction_notice(time, &self.queue));
    }

    /// Counts values that were lost before they arrived.
    pub fn add_lost(&self, count: u64) {
        self.queue.lost.fetch_add(count, Ordering::Relaxed);
    }
}

impl Shared {
    pub(crate) fn new(notices: SyncSender<(u64, Notice)>, lossless: bool) -> Self {
        Self {
            topics: Mutex::default(),
            notices,
            order: AtomicU64::new(0),
            lossless,
            closed: AtomicBool::new(false),
            writer_thread: OnceLock::new(),
            lost_events: AtomicU64::new(0),
            written: AtomicU64::new(0),
            dropped: AtomicU64::new(0),
            bytes: AtomicU64::new(0),
            evicted: AtomicU64::new(0),
            error: Mutex::default(),
            files: Mutex::default(),
            parts: Mutex::default(),
            clock: OnceLock::new(),
            room_lock: Mutex::new(()),
            room_condvar: Condvar::new(),
        }
    }

    /// Sends a notice to the writing thread. A notice for which there is no room is counted as lost.
    pub(crate) fn push_notice(&self, notice: Notice) {
        if self.closed.load(Ordering::Acquire) {
            return;
        }
        match self.notices.try_send((self.assign_order(), notice)) {
            Ok(()) => {}
            Err(TrySendError::Full(notice)) if self.lossless => {
                self.wake();
                // This fails only after the recording was closed.
                let _ = self.notices.send(notice);
            }
            Err(TrySendError::Full(_)) => {
                self.lost_events.fetch_add(1, Ordering::Relaxed);
            }
            Err(TrySendError::Disconnected(_)) => {}
        }
    }

    /// Returns the number of the next value or notice.
    fn assign_order(&self) -> u64 {
        self.order.fetch_add(1, Ordering::AcqRel)
    }

    /// Returns the number that is assigned next: all lower numbers have been assigned. If a single thread
    /// publishes everything, all of these except the last have arrived.
    pub(crate) fn next_order(&self) -> u64 {
        self.order.load(Ordering::Acquire)
    }

    /// Returns the number of values that were lost before they were written, by topic.
    pub(crate) fn lost_by_topic(&self) -> BTreeMap<String, u64> {
        let queues = self.topics.lock();
        queues
            .iter()
            .filter(|queue| queue.is_recorded)
            .map(|queue| (queue.name.clone(), queue.lost.load(Ordering::Relaxed)))
            .filter(|(_, lost)| *lost > 0)
            .collect()
    }

    pub(crate) fn wake(&self) {
        if let Some(thread) = self.writer_thread.get() {
            thread.unpark();
        }
    }

    /// Notifies publishers that wait for room, after the writing thread has emptied slots.
    pub(crate) fn notify_room(&self) {
        if self.lossless {
            drop(self.room_lock.lock());
            self.room_condvar.notify_all();
        }
    }

    fn wait_for_room(&self, queue: &TopicQueue) -> Option<Box<Slot>> {
        let mut waiting = self.lossless.then(|| self.room_lock.lock())?;
        loop {
            if let Some(slot) = queue.free.pop() {
                return Some(slot);
            }
            if self.closed.load(Ordering::Acquire) {
                return None;
            }
            self.wake();
            self.room_condvar.wait_for(&mut waiting, ROOM_TIMEOUT);
        }
    }
}

#[cfg(test)]
mod tests {
    use std::sync::mpsc::sync_channel;

    use super::*;

    #[test]
    fn the_bytes_of_a_panel_are_limited_and_large_slots_are_freed() {
        let (notices, _receiver) = sync_channel(1);
        let queue = TopicQueue::new(
            "/panels/goon".to_owned(),
            TopicContent::PANEL,
            BTreeMap::new(),
            None,
            true,
        );
        let topic = Topic {
            queue: Arc::new(queue),
            shared: Arc::new(Shared::new(notices, false)),
        };
        let stamps = Stamps {
            published: 0,
            measured: 0,
            sequence: 0,
        };
        let put = |bytes: usize| topic.put_message(&vec![0; bytes], stamps);
        let write = || {
            topic
                .queue
                .recycle(topic.queue.full.pop().expect("a drawing is queued"))
        };
        assert!(put(2 * PANEL_BYTES), "a single drawing always fits");
        assert!(!put(1), "a second drawing does not fit");
        write();
        assert!(put(PANEL_BYTES / 2) && put(PANEL_BYTES / 2));
        assert!(!put(1));
        write();
        assert!(put(1));
        assert_eq!(topic.queue.lost.load(Ordering::Relaxed), 2);
        write();
        write();
        let slots = std::iter::from_fn(|| topic.queue.free.pop());
        assert!(slots.fold(0, |largest, slot| largest.max(slot.bytes.capacity())) <= TOPIC_BYTES);
    }
}
