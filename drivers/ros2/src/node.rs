//! A node of ROS 2, as a driver handles it from its iterations: what is to be sent is handed over, what has come is taken. It
//! never waits for the network; a thread of its own does, and says nothing that was not handed to it.

use std::io;
use std::sync::Arc;
use std::thread;
use std::time::{Duration, Instant};

use zenoh::Config;
use zenoh::bytes::ZBytes;

use crate::keys::{Name, Topic};
use crate::session;
use crate::shared::Shared;

/// How long the last words may take.
const FAREWELL: Duration = Duration::from_millis(300);

/// What a node is.
#[derive(Clone, Debug)]
pub(crate) struct Plan {
    /// How Zenoh is reached.
    pub(crate) config: Config,
    /// The same in words, as in "tcp/localhost:7447".
    pub(crate) place: String,
    pub(crate) name: Name,
    pub(crate) publications: Vec<Topic>,
    pub(crate) subscriptions: Vec<Topic>,
}

/// A node that is looked for, or there; dropped, it goes without a word more.
#[derive(Debug)]
pub(crate) struct Node(Arc<Shared>);

/// How the node stands.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Link {
    Connecting,
    /// It has its place and nobody beside it.
    Alone,
    Connected,
    /// Why it is not; the next attempt comes by itself.
    Lost(String),
}

/// A message that has come.
#[derive(Clone, Debug)]
pub(crate) struct Arrived {
    pub(crate) message: ZBytes,
    pub(crate) at: Instant,
}

impl Node {
    /// Starts looking for its place.
    ///
    /// # Errors
    /// If the system gives no thread.
    pub(crate) fn start(plan: Plan) -> io::Result<Self> {
        let shared = Arc::new(Shared::new(plan.publications.len(), plan.subscriptions.len()));
        let theirs = Arc::clone(&shared);
        thread::Builder::new()
            .name("ros2".to_owned())
            .spawn(move || session::run(&theirs, &plan))?;
        Ok(Self(shared))
    }

    /// Whether anybody listens to this publication.
    pub(crate) fn is_wanted(&self, publication: usize) -> bool {
        self.0.is_wanted(publication)
    }

    /// Hands over what is to be sent, in place of what was not sent yet.
    pub(crate) fn publish(&self, publication: usize, messages: Vec<Vec<u8>>) {
        self.0.order(publication, messages);
    }

    /// The newest message of this subscription, once.
    pub(crate) fn take(&self, subscription: usize) -> Option<Arrived> {
        self.0.take(subscription)
    }

    /// How it stands, and the attempts since it was last connected.
    pub(crate) fn link(&self) -> (Link, u32) {
        self.0.link()
    }

    /// What is to be said of others, once.
    pub(crate) fn remarks(&self) -> Vec<String> {
        self.0.remarks()
    }

    /// Lets what was handed over go out, and goes; it waits a moment for that, and no longer.
    pub(crate) fn rest(self) {
        self.0.finish(FAREWELL);
    }
}

impl Drop for Node {
    fn drop(&mut self) {
        self.0.finish(Duration::ZERO);
    }
}
