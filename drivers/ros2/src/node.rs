//! A ROS 2 node, as a driver uses it in its iterations: it submits messages and takes those that arrived. It
//! never waits for the network. Its own thread does, and sends only what was submitted.

use std::io;
use std::sync::Arc;
use std::thread;
use std::time::{Duration, Instant};

use zenoh::Config;
use zenoh::bytes::ZBytes;

use crate::keys::{Direction, NodeName, Topic};
use crate::session;
use crate::shared::Shared;

/// Time limit for sending the last messages.
const CLOSE_TIMEOUT: Duration = Duration::from_millis(300);

/// The parameters of a node.
#[derive(Clone, Debug)]
pub(crate) struct NodeConfig {
    /// Zenoh's configuration.
    pub(crate) config: Config,
    /// Its address in messages, such as "tcp/localhost:7447".
    pub(crate) endpoint: String,
    pub(crate) name: NodeName,
    pub(crate) publications: Vec<Topic>,
    pub(crate) subscriptions: Vec<Topic>,
}

impl NodeConfig {
    /// Its topics of that direction.
    pub(crate) fn topics(&self, direction: Direction) -> &[Topic] {
        match direction {
            Direction::Publish => &self.publications,
            Direction::Subscribe => &self.subscriptions,
        }
    }
}

/// A node, connected or not. Dropping it requests the end of its thread and does not wait for it.
#[derive(Debug)]
pub(crate) struct Node(Arc<Shared>);

/// The state of the node's connection.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum NodeState {
    Connecting,
    /// The session is open, but no router and no peer is connected.
    Alone,
    Connected,
    /// The reason of the loss. The next attempt occurs by itself.
    Lost(String),
}

/// A message that arrived.
#[derive(Clone, Debug)]
pub(crate) struct ReceivedMessage {
    pub(crate) message: ZBytes,
    pub(crate) received_at: Instant,
}

impl Node {
    /// Starts the node's thread, which connects.
    ///
    /// # Errors
    /// If the system cannot start a thread.
    pub(crate) fn start(config: NodeConfig) -> io::Result<Self> {
        let shared = Arc::new(Shared::new(config.publications.len(), config.subscriptions.len()));
        let thread_shared = Arc::clone(&shared);
        thread::Builder::new()
            .name("ros2".to_owned())
            .spawn(move || session::run(&thread_shared, &config))?;
        Ok(Self(shared))
    }

    /// Whether this publication has subscribers.
    pub(crate) fn has_subscribers(&self, publication: usize) -> bool {
        self.0.has_subscribers(publication)
    }

    /// Whether all messages submitted to this publication were taken by its thread.
    pub(crate) fn has_sent(&self, publication: usize) -> bool {
        self.0.has_sent(publication)
    }

    /// Submits messages to send, and replaces those that were not sent yet.
    pub(crate) fn publish(&self, publication: usize, messages: Vec<Vec<u8>>) {
        self.0.submit(publication, messages);
    }

    /// Takes the newest message of this subscription.
    pub(crate) fn take(&self, subscription: usize) -> Option<ReceivedMessage> {
        self.0.take(subscription)
    }

    /// Returns the state of the connection, and the failed attempts since it was last connected.
    pub(crate) fn state(&self) -> (NodeState, u32) {
        self.0.state()
    }

    /// Takes the remarks on other nodes.
    pub(crate) fn remarks(&self) -> Vec<String> {
        self.0.remarks()
    }

    /// Ends the node after the submitted messages are sent, and waits for that for 300 ms at most.
    pub(crate) fn close(self) {
        if self.0.publishes() {
            self.0.finish(CLOSE_TIMEOUT);
        }
    }
}

impl Drop for Node {
    fn drop(&mut self) {
        self.0.finish(Duration::ZERO);
    }
}
