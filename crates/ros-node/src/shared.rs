//! The state shared by the owner of a node, the node's thread and Zenoh's threads. No thread holds a lock
//! while it waits for the network, so the owner does not wait for it either.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use zenoh::bytes::ZBytes;

use crate::keys::Direction;
use crate::node::{NodeState, ReceivedMessage};

/// Most remarks per node. They are remembered so that none is repeated.
const MAX_REMARKS: usize = 64;

/// Submitted messages, arrived messages and status.
#[derive(Debug)]
pub(crate) struct Shared {
    queue: Mutex<SendQueue>,
    changed: Condvar,
    subscribed: Vec<AtomicBool>,
    arrived: Vec<Mutex<Option<ReceivedMessage>>>,
    status: Mutex<NodeStatus>,
}

#[derive(Debug)]
struct SendQueue {
    /// The messages to send next, per publication. New ones replace those that were not sent in time.
    waiting: Vec<Vec<Vec<u8>>>,
    /// Topics that other nodes have in the opposite direction, and that are to be announced.
    met: Vec<(Direction, usize)>,
    ending: bool,
    ended: bool,
}

#[derive(Debug)]
struct NodeStatus {
    state: NodeState,
    attempts: u32,
    remarks: Vec<String>,
    past_remarks: Vec<String>,
}

/// The next work of the thread.
#[derive(Debug, Default)]
pub(crate) struct Work {
    /// Numbers of publications, and their messages to send.
    pub(crate) batches: Vec<(usize, Vec<Vec<u8>>)>,
    /// Directions and numbers of topics to announce.
    pub(crate) met: Vec<(Direction, usize)>,
    /// Whether the node must end afterwards.
    pub(crate) ending: bool,
}

impl Shared {
    pub(crate) fn new(publications: usize, subscriptions: usize) -> Self {
        Self {
            queue: Mutex::new(SendQueue {
                waiting: vec![Vec::new(); publications],
                met: Vec::new(),
                ending: false,
                ended: false,
            }),
            changed: Condvar::new(),
            subscribed: (0..publications).map(|_| AtomicBool::new(false)).collect(),
            arrived: (0..subscriptions).map(|_| Mutex::new(None)).collect(),
            status: Mutex::new(NodeStatus {
                state: NodeState::Connecting,
                attempts: 0,
                remarks: Vec::new(),
                past_remarks: Vec::new(),
            }),
        }
    }

    pub(crate) fn publishes(&self) -> bool {
        !self.subscribed.is_empty()
    }

    pub(crate) fn has_subscribers(&self, publication: usize) -> bool {
        self.subscribed[publication].load(Ordering::Relaxed)
    }

    pub(crate) fn has_sent(&self, publication: usize) -> bool {
        lock(&self.queue).waiting[publication].is_empty()
    }

    /// Submits messages to send, and replaces those that were not sent yet.
    pub(crate) fn submit(&self, publication: usize, messages: Vec<Vec<u8>>) {
        lock(&self.queue).waiting[publication] = messages;
        self.changed.notify_one();
    }

    pub(crate) fn take(&self, subscription: usize) -> Option<ReceivedMessage> {
        lock(&self.arrived[subscription]).take()
    }

    pub(crate) fn state(&self) -> (NodeState, u32) {
        let status = lock(&self.status);
        (status.state.clone(), status.attempts)
    }

    pub(crate) fn remarks(&self) -> Vec<String> {
        std::mem::take(&mut lock(&self.status).remarks)
    }

    /// Requests the end of the thread, and waits for that for at most `timeout`.
    pub(crate) fn finish(&self, timeout: Duration) {
        let mut queue = lock(&self.queue);
        queue.ending = true;
        self.changed.notify_one();
        let until = Instant::now() + timeout;
        while !queue.ended {
            let remaining = until.saturating_duration_since(Instant::now());
            if remaining.is_zero() {
                break;
            }
            queue = wait(&self.changed, queue, remaining);
        }
    }

    /// Returns the work to do. Waits for some for at most `timeout`.
    pub(crate) fn work(&self, timeout: Duration) -> Work {
        let mut queue = lock(&self.queue);
        if !queue.ending && queue.met.is_empty() && queue.waiting.iter().all(Vec::is_empty) {
            queue = wait(&self.changed, queue, timeout);
        }
        let met = std::mem::take(&mut queue.met);
        let batches = queue.waiting.iter_mut().enumerate();
        Work {
            met,
            batches: batches
                .filter(|(_, batch)| !batch.is_empty())
                .map(|(number, batch)| (number, std::mem::take(batch)))
                .collect(),
            ending: queue.ending,
        }
    }

    /// Reports that another node has this topic in the opposite direction.
    pub(crate) fn meet(&self, direction: Direction, number: usize) {
        lock(&self.queue).met.push((direction, number));
        self.changed.notify_one();
    }

    /// Waits between two attempts. Returns whether the node must end instead of trying again.
    pub(crate) fn pause(&self, pause: Duration) -> bool {
        let until = Instant::now() + pause;
        loop {
            let remaining = until.saturating_duration_since(Instant::now());
            let work = self.work(remaining);
            if work.ending || remaining.is_zero() {
                return work.ending;
            }
        }
    }

    pub(crate) fn set_subscribed(&self, publication: usize, subscribed: bool) {
        self.subscribed[publication].store(subscribed, Ordering::Relaxed);
    }

    pub(crate) fn arrive(&self, subscription: usize, message: ZBytes) {
        let arrived = ReceivedMessage {
            message,
            received_at: Instant::now(),
        };
        *lock(&self.arrived[subscription]) = Some(arrived);
    }

    pub(crate) fn set_state(&self, state: NodeState) {
        let mut status = lock(&self.status);
        if state == NodeState::Connected {
            status.attempts = 0;
        }
        status.state = state;
    }

    /// Records a failed attempt.
    pub(crate) fn failed(&self, reason: String) {
        let mut status = lock(&self.status);
        status.attempts = status.attempts.saturating_add(1);
        status.state = NodeState::Lost(reason);
    }

    /// Adds a remark on other nodes, unless it is a repetition or there are too many.
    pub(crate) fn remark(&self, remark: String) {
        let mut status = lock(&self.status);
        if status.past_remarks.len() < MAX_REMARKS && !status.past_remarks.contains(&remark) {
            status.past_remarks.push(remark.clone());
            status.remarks.push(remark);
        }
    }

    /// Records that the thread ended.
    pub(crate) fn end(&self) {
        lock(&self.queue).ended = true;
        self.changed.notify_all();
    }
}

fn lock<T>(shared: &Mutex<T>) -> MutexGuard<'_, T> {
    shared.lock().unwrap_or_else(PoisonError::into_inner)
}

fn wait<'a>(
    changed: &Condvar,
    queue: MutexGuard<'a, SendQueue>,
    timeout: Duration,
) -> MutexGuard<'a, SendQueue> {
    let waited = changed.wait_timeout(queue, timeout);
    waited.unwrap_or_else(PoisonError::into_inner).0
}
