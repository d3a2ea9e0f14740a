//! The state shared by a driver, its node's thread and Zenoh's threads. No thread holds a lock while it waits
//! for the network, so that no iteration waits for it either.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use zenoh::bytes::ZBytes;

use crate::node::{Arrived, Link};

/// Most remarks per node. They are remembered so that none is repeated.
const MOST_REMARKS: usize = 64;

/// Submitted messages, arrived messages and news.
#[derive(Debug)]
pub(crate) struct Shared {
    orders: Mutex<Orders>,
    changed: Condvar,
    wanted: Vec<AtomicBool>,
    arrived: Vec<Mutex<Option<Arrived>>>,
    news: Mutex<News>,
}

#[derive(Debug)]
struct Orders {
    /// The messages to send next, per publication. New ones replace those that were not sent in time.
    waiting: Vec<Vec<Vec<u8>>>,
    ending: bool,
    ended: bool,
}

#[derive(Debug)]
struct News {
    link: Link,
    attempts: u32,
    remarks: Vec<String>,
    made: Vec<String>,
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
            orders: Mutex::new(Orders {
                waiting: vec![Vec::new(); publications],
                ending: false,
                ended: false,
            }),
            changed: Condvar::new(),
            wanted: (0..publications).map(|_| AtomicBool::new(false)).collect(),
            arrived: (0..subscriptions).map(|_| Mutex::new(None)).collect(),
            news: Mutex::new(News {
                link: Link::Connecting,
                attempts: 0,
                remarks: Vec::new(),
                made: Vec::new(),
            }),
        }
    }

    pub(crate) fn is_wanted(&self, publication: usize) -> bool {
        self.wanted[publication].load(Ordering::Relaxed)
    }

    /// Submits messages to send, and replaces those that were not sent yet.
    pub(crate) fn order(&self, publication: usize, messages: Vec<Vec<u8>>) {
        lock(&self.orders).waiting[publication] = messages;
        self.changed.notify_one();
    }

    pub(crate) fn take(&self, subscription: usize) -> Option<Arrived> {
        lock(&self.arrived[subscription]).take()
    }

    pub(crate) fn link(&self) -> (Link, u32) {
        let news = lock(&self.news);
        (news.link.clone(), news.attempts)
    }

    pub(crate) fn remarks(&self) -> Vec<String> {
        std::mem::take(&mut lock(&self.news).remarks)
    }

    /// Asks the thread to end, and waits for that for at most `patience`.
    pub(crate) fn finish(&self, patience: Duration) {
        let mut orders = lock(&self.orders);
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
        let mut orders = lock(&self.orders);
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

    pub(crate) fn want(&self, publication: usize, wanted: bool) {
        self.wanted[publication].store(wanted, Ordering::Relaxed);
    }

    pub(crate) fn arrive(&self, subscription: usize, message: ZBytes) {
        let arrived = Arrived {
            message,
            at: Instant::now(),
        };
        *lock(&self.arrived[subscription]) = Some(arrived);
    }

    pub(crate) fn stands(&self, link: Link) {
        let mut news = lock(&self.news);
        if link == Link::Connected {
            news.attempts = 0;
        }
        news.link = link;
    }

    /// Records a failed attempt.
    pub(crate) fn failed(&self, why: String) {
        let mut news = lock(&self.news);
        news.attempts = news.attempts.saturating_add(1);
        news.link = Link::Lost(why);
    }

    /// Adds a remark on other nodes, unless it is a repetition or there are too many.
    pub(crate) fn remark(&self, remark: String) {
        let mut news = lock(&self.news);
        if news.made.len() < MOST_REMARKS && !news.made.contains(&remark) {
            news.made.push(remark.clone());
            news.remarks.push(remark);
        }
    }

    /// Records that the thread ended.
    pub(crate) fn end(&self) {
        lock(&self.orders).ended = true;
        self.changed.notify_all();
    }
}

fn lock<T>(shared: &Mutex<T>) -> MutexGuard<'_, T> {
    shared.lock().unwrap_or_else(PoisonError::into_inner)
}

fn wait<'a>(changed: &Condvar, orders: MutexGuard<'a, Orders>, patience: Duration) -> MutexGuard<'a, Orders> {
    let waited = changed.wait_timeout(orders, patience);
    waited.unwrap_or_else(PoisonError::into_inner).0
}
