//! The state shared by a driver, its node's thread and Zenoh's threads. No thread holds a lock while it waits
//! for the network, so that no iteration waits for it either.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use zenoh::bytes::ZBytes;

use crate::node::{NodeState, ReceivedMessage};

/// Most remarks per node. They are remembered so that none is repeated.
const MAX_REMARKS: usize = 64;

/// Submitted messages, arrived messages and news.
#[derive(Debug)]
pub(crate) struct Shared {
    queue: Mutex<SendQueue>,
    changed: Condvar,
    wanted: Vec<AtomicBool>,
    arrived: Vec<Mutex<Option<ReceivedMessage>>>,
    status: Mutex<NodeStatus>,
}

#[derive(Debug)]
struct SendQueue {
    /// The messages to send next, per publication. New ones replace those that were not sent in time.
    waiting: Vec<Vec<Vec<u8>>>,
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
    /// Whether the node must end afterwards.
    pub(crate) ending: bool,
}

impl Shared {
    pub(crate) fn new(publications: usize, subscriptions: usize) -> Self {
        Self {
            queue: Mutex::new(SendQueue {
                waiting: vec![Vec::new(); publications],
                ending: false,
                ended: false,
            }),
            changed: Condvar::new(),
            wanted: (0..publications).map(|_| AtomicBool::new(false)).collect(),
            arrived: (0..subscriptions).map(|_| Mutex::new(None)).collect(),
            status: Mutex::new(NodeStatus {
                state: NodeState::Connecting,
                attempts: 0,
                remarks: Vec::new(),
                past_remarks: Vec::new(),
            }),
        }
    }

    pub(crate) fn is_wanted(&self, publication: usize) -> bool {
        self.wanted[publication].load(Ordering::Relaxed)
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
        let news = lock(&self.status);
        (news.state.clone(), news.attempts)
    }

    pub(crate) fn remarks(&self) -> Vec<String> {
        std::mem::take(&mut lock(&self.status).remarks)
    }

    /// Asks the thread to end, and waits for that for at most `patience`.
    pub(crate) fn finish(&self, patience: Duration) {
        let mut orders = lock(&self.queue);
        orders.ending = true;
        self.changed.notify_one();
        let until = Instant::now() + patience;
        while !orders.ended {
            let left = until.saturating_duration_since(Instant::now());
            if left.is_zero() {
                break;
            }
            orders = wait(&self.changed, orders, left);
        }
    }

    /// Returns the work to do. Waits for some for at most `patience`.
    pub(crate) fn work(&self, patience: Duration) -> Work {
        let mut orders = lock(&self.queue);
        if !orders.ending && orders.waiting.iter().all(Vec::is_empty) {
            orders = wait(&self.changed, orders, patience);
        }
        let batches = orders.waiting.iter_mut().enumerate();
        Work {
            batches: batches
                .filter(|(_, batch)| !batch.is_empty())
                .map(|(number, batch)| (number, std::mem::take(batch)))
                .collect(),
            ending: orders.ending,
        }
    }

    /// Waits between two attempts. Returns whether the node must end instead of trying again.
    pub(crate) fn pause(&self, pause: Duration) -> bool {
        let until = Instant::now() + pause;
        loop {
            let left = until.saturating_duration_since(Instant::now());
            let work = self.work(left);
            if work.ending || left.is_zero() {
                return work.ending;
            }
        }
    }

    pub(crate) fn set_wanted(&self, publication: usize, wanted: bool) {
        self.wanted[publication].store(wanted, Ordering::Relaxed);
    }

    pub(crate) fn arrive(&self, subscription: usize, message: ZBytes) {
        let arrived = ReceivedMessage {
            message,
            received_at: Instant::now(),
        };
        *lock(&self.arrived[subscription]) = Some(arrived);
    }

    pub(crate) fn set_state(&self, link: NodeState) {
        let mut news = lock(&self.status);
        if link == NodeState::Connected {
            news.attempts = 0;
        }
        news.state = link;
    }

    /// Records a failed attempt.
    pub(crate) fn failed(&self, why: String) {
        let mut news = lock(&self.status);
        news.attempts = news.attempts.saturating_add(1);
        news.state = NodeState::Lost(why);
    }

    /// Adds a remark on other nodes, unless it is a repetition or there are too many.
    pub(crate) fn remark(&self, remark: String) {
        let mut news = lock(&self.status);
        if news.past_remarks.len() < MAX_REMARKS && !news.past_remarks.contains(&remark) {
            news.past_remarks.push(remark.clone());
            news.remarks.push(remark);
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
    orders: MutexGuard<'a, SendQueue>,
    patience: Duration,
) -> MutexGuard<'a, SendQueue> {
    let waited = changed.wait_timeout(orders, patience);
    waited.unwrap_or_else(PoisonError::into_inner).0
}
