//! The publishers of a connected node. Its thread sends with them what waits. Its owner sends small messages itself if nothing
//! waits, which saves the time until the thread wakes up.
//!
//! The owner hardly waits for the network. Only one thread sends at a time, and the owner does not wait for the other one. A
//! message that fits a batch of Zenoh is copied into it. Without a free batch Zenoh waits for 0.2 ms for each connection, and then
//! drops messages at once until there is one (`wait_before_drop`). After one that took long, the owner leaves sending to the
//! thread.

use std::time::{Duration, Instant};

use parking_lot::{Mutex, MutexGuard};
use zenoh::Wait;
use zenoh::bytes::ZBytes;
use zenoh::pubsub::Publisher;

use crate::attachment::{Gid, attachment_now};
use crate::keys::BATCH_BYTES;
use crate::latched::Cache;
use crate::own::OwnCommands;

/// The size up to which the owner sends, bytes.
const OWNER_SENDS_BYTES: usize = BATCH_BYTES / 2;
/// The time that a message needs at most if the network takes it at once.
const AT_ONCE: Duration = Duration::from_micros(150);
/// How long the thread sends alone after a message that needed more.
const ALONE_AFTER_LARGE: Duration = Duration::from_secs(1);

/// The publishers by number; empty while the node is not connected.
#[derive(Debug, Default)]
pub(crate) struct Publishers(Mutex<Sending>);

#[derive(Debug, Default)]
pub(crate) struct Sending {
    publishers: Vec<DeclaredPublisher>,
    /// Until when the thread sends alone.
    rests_until: Option<Instant>,
}

/// A publication, and the state of its attachments.
#[derive(Debug)]
pub(crate) struct DeclaredPublisher {
    pub(crate) publisher: Publisher<'static>,
    pub(crate) sequence: i64,
    /// Identifier of the publication for ROS 2.
    pub(crate) gid: Gid,
    /// The newest messages of a latched topic.
    pub(crate) cache: Option<Cache>,
    pub(crate) _own: Option<OwnCommands>,
}

impl Publishers {
    /// Sets the publishers of a session.
    pub(crate) fn set(&self, publishers: Vec<DeclaredPublisher>) {
        self.0.lock().publishers = publishers;
    }

    /// For the thread of the node: waits until the owner has sent.
    pub(crate) fn wait(&self) -> MutexGuard<'_, Sending> {
        self.0.lock()
    }

    /// For the owner: none if the thread sends, or if it shall send this message.
    pub(crate) fn at_once(&self, message: &[u8]) -> Option<MutexGuard<'_, Sending>> {
        let sending = self.0.try_lock()?;
        let is_ready = !sending.publishers.is_empty() && message.len() <= OWNER_SENDS_BYTES;
        (is_ready && !sending.is_left_to_thread()).then_some(sending)
    }
}

impl Sending {
    /// Whether the thread sends alone, because a message took long.
    pub(crate) fn is_left_to_thread(&self) -> bool {
        self.rests_until.is_some_and(|until| Instant::now() < until)
    }

    /// Sends a message. What cannot be sent is lost, as on an unreliable network; the check of the connection reports the
    /// reason.
    pub(crate) fn put(&mut self, publication: usize, message: Vec<u8>) {
        let Some(publisher) = self.publishers.get_mut(publication) else {
            return;
        };
        let (begin, is_small) = (Instant::now(), message.len() <= OWNER_SENDS_BYTES);
        let _ = publisher.put(message);
        let end = Instant::now();
        if is_small && end - begin > AT_ONCE {
            self.rests_until = Some(end + ALONE_AFTER_LARGE);
        }
    }
}

impl DeclaredPublisher {
    fn put(&mut self, message: Vec<u8>) -> zenoh::Result<()> {
        self.sequence += 1;
        let message = ZBytes::from(message);
        let attachment = ZBytes::from(attachment_now(self.sequence, self.gid));
        let kept = self.cache.as_ref();
        let time = kept.map(|cache| cache.keep(message.clone(), attachment.clone()));
        let put = self.publisher.put(message).attachment(attachment);
        put.timestamp(time).wait()
    }
}
