//! A ROS 2 node, as its owner uses it: the owner submits messages and takes those that arrived. The node's own thread waits
//! for the network, and sends what was submitted and not sent at once.

use std::collections::VecDeque;
use std::fmt;
use std::io;
use std::sync::Arc;
use std::thread;
use std::time::{Duration, Instant};

use zenoh::Config;
use zenoh::bytes::ZBytes;

use crate::keys::{Direction, Middleware, NO_HASH, NodeName, Service, Topic};
use crate::remaps::Remaps;
use crate::services::{Client, Request, Response};
use crate::session;
use crate::shared::Shared;

/// Time limit for sending the last messages.
const CLOSE_TIMEOUT: Duration = Duration::from_millis(300);

/// The parameters of a node.
#[derive(Clone, Debug)]
pub struct NodeConfig {
    /// Zenoh's configuration.
    pub config: Config,
    /// Its address in messages, such as "tcp/localhost:7447".
    pub endpoint: String,
    /// Its name and domain.
    pub name: NodeName,
    /// What it publishes; a publication's number is its index.
    pub publications: Vec<Topic>,
    /// What it subscribes to; a subscription's number is its index.
    pub subscriptions: Vec<Topic>,
    /// What it offers; a service's number is its index.
    pub services: Vec<Service>,
    /// The number of the service whose requests wait for no others, if there is one.
    pub urgent_service: Option<usize>,
    /// What it calls; a client's number is its index.
    pub clients: Vec<Client>,
    /// The rules that replace names of its topics and services when it starts.
    pub remaps: Remaps,
    /// What it calls when something arrives.
    pub arrival: Arrival,
}

/// What a node calls in a thread of Zenoh when a message, a request or a response arrives, and when a service that it
/// calls is there or gone. It must not block.
#[derive(Clone, Default)]
pub struct Arrival {
    call: Option<Arc<dyn Fn() + Send + Sync>>,
    except: Option<usize>,
}

impl Arrival {
    /// Calls this function.
    pub fn new(call: impl Fn() + Send + Sync + 'static) -> Self {
        Self {
            call: Some(Arc::new(call)),
            except: None,
        }
    }

    /// The same, but for messages of the subscription of that number.
    #[must_use]
    pub fn except(self, subscription: usize) -> Self {
        Self {
            except: Some(subscription),
            ..self
        }
    }

    /// Calls it for a message of a subscription.
    pub(crate) fn call_for(&self, subscription: usize) {
        if self.except != Some(subscription) {
            self.call();
        }
    }

    pub(crate) fn call(&self) {
        if let Some(call) = &self.call {
            call();
        }
    }
}

impl fmt::Debug for Arrival {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Arrival")
            .field("except", &self.except)
            .finish_non_exhaustive()
    }
}

impl NodeConfig {
    /// A node without topics and services, which connects by this configuration. `endpoint` is its address in
    /// messages.
    #[must_use]
    pub fn new(name: NodeName, (config, endpoint): (Config, String)) -> Self {
        Self {
            config,
            endpoint,
            name,
            publications: Vec::new(),
            subscriptions: Vec::new(),
            services: Vec::new(),
            urgent_service: None,
            clients: Vec::new(),
            remaps: Remaps::default(),
            arrival: Arrival::default(),
        }
    }

    /// Gives its topics and services the names that the rules state, and the hashes that the middleware has.
    fn adapted(mut self) -> Self {
        let topics = self.publications.iter_mut().chain(&mut self.subscriptions);
        let clients = self.clients.iter_mut().map(|client| &mut client.service);
        let services = self.services.iter_mut().chain(clients);
        let entities = topics
            .map(|topic| (&mut topic.name, &mut topic.hash))
            .chain(services.map(|service| (&mut service.name, &mut service.hash)));
        for (name, hash) in entities {
            *name = self.remaps.apply(&self.name, name);
            if self.name.middleware == Middleware::RmwHumble {
                NO_HASH.clone_into(hash);
            }
        }
        self
    }

    /// Its topics of each direction. Services have the keys of topics.
    pub(crate) fn all_topics(&self) -> [(Direction, Vec<Topic>); 4] {
        [
            (Direction::Publish, self.publications.clone()),
            (Direction::Subscribe, self.subscriptions.clone()),
            (
                Direction::Serve,
                self.services.iter().map(Service::topic).collect(),
            ),
            (
                Direction::Call,
                self.clients.iter().map(|client| client.service.topic()).collect(),
            ),
        ]
    }
}

/// A node, connected or not. Dropping it requests the end of its thread and does not wait for it.
#[derive(Debug)]
pub struct Node(pub(crate) Arc<Shared>);

/// The state of the node's connection.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum NodeState {
    /// The first attempt is under way.
    Connecting,
    /// The session is open, but no router and no peer is connected.
    Alone,
    /// A router or a peer is connected.
    Connected,
    /// The reason of the loss. The next attempt occurs by itself.
    Lost(String),
}

/// A message that arrived.
#[derive(Clone, Debug)]
pub struct ReceivedMessage {
    /// Its bytes.
    pub message: ZBytes,
    /// When it arrived.
    pub received_at: Instant,
    /// The bytes at its end that the sender's version of its type does not have.
    pub(crate) missing: &'static [u8],
}

impl ReceivedMessage {
    /// Its bytes, in the pieces in which they came. Fields at the end that the sender's version of its type does not have are
    /// zero.
    pub fn pieces(&self) -> Vec<&[u8]> {
        self.message.slices().chain([self.missing]).collect()
    }
}

impl Node {
    /// Starts the node's thread, which connects.
    ///
    /// # Errors
    /// If the system cannot start a thread.
    pub fn start(config: NodeConfig) -> io::Result<Self> {
        let config = config.adapted();
        let shared = Arc::new(Shared::new(&config));
        let thread_shared = Arc::clone(&shared);
        thread::Builder::new()
            .name("ros2".to_owned())
            .spawn(move || session::run(&thread_shared, &config))?;
        Ok(Self(shared))
    }

    /// Whether this publication has subscribers.
    pub fn has_subscribers(&self, publication: usize) -> bool {
        self.0.has_subscribers(publication)
    }

    /// Whether all messages submitted to this publication were taken by its thread.
    pub fn has_sent(&self, publication: usize) -> bool {
        self.0.has_sent(publication)
    }

    /// Whether a message of this publication waits for the thread. If so, the owner is called as for an arrival once messages
    /// were taken.
    pub fn is_waiting(&self, publication: usize) -> bool {
        self.0.is_waiting(publication)
    }

    /// Sends a message at once if nothing waits, or submits messages and replaces those that were not sent yet.
    pub fn publish(&self, publication: usize, messages: Vec<Vec<u8>>) {
        self.0.publish(publication, messages);
    }

    /// Sends a message at once if nothing waits, or submits it after those that wait, at most as many as the depth of the
    /// publication.
    pub fn append(&self, publication: usize, message: Vec<u8>) {
        self.0.append(publication, message);
    }

    /// Takes the newest message of this subscription, and drops those before it.
    pub fn take(&self, subscription: usize) -> Option<ReceivedMessage> {
        self.0.take_all(subscription).pop_back()
    }

    /// Takes the messages of this subscription that wait, the oldest first: at most as many as its depth.
    pub fn take_all(&self, subscription: usize) -> VecDeque<ReceivedMessage> {
        self.0.take_all(subscription)
    }

    /// Sets whether messages of a subscription are wanted that is announced [`Announced::WhileWanted`](crate::Announced).
    pub fn want(&self, subscription: usize, is_wanted: bool) {
        self.0.want(subscription, is_wanted);
    }

    /// Whether several nodes send the messages of a subscription that has one source. It receives none of them then.
    pub fn is_contradicted(&self, subscription: usize) -> bool {
        self.0.is_contradicted(subscription)
    }

    /// Takes the next request to a service that is not urgent, from each service in turn. Waits for one for at most `timeout`.
    /// A request that is dropped has no response.
    pub fn take_request(&self, timeout: Duration) -> Option<Request> {
        self.0.requests.take(timeout)
    }

    /// Takes the next request to the service of that number, which is not urgent.
    pub fn take_request_of(&self, service: usize) -> Option<Request> {
        self.0.requests.take_of(service)
    }

    /// Takes all requests to the urgent service. Waits for one for at most `timeout`.
    pub fn take_urgent(&self, timeout: Duration) -> Vec<Request> {
        self.0.requests.take_urgent(timeout)
    }

    /// Sends the response to a request on the calling thread, which waits for the network.
    pub fn reply_at_once(request: Request, message: Vec<u8>) {
        // Without a connection nobody waits for it any more.
        let _ = request.reply(Ok(message));
    }

    /// Submits the response to a request.
    pub fn reply(&self, request: Request, message: Vec<u8>) {
        self.0.reply(request, Ok(message));
    }

    /// Submits the reason why a request has no response. A caller of jde receives it; those of `rmw_zenoh` have no
    /// outcome.
    pub fn refuse(&self, request: Request, reason: String) {
        self.0.reply(request, Err(reason));
    }

    /// Whether a node offers the service of this client.
    pub fn has_server(&self, client: usize) -> bool {
        self.0.has_server(client)
    }

    /// Submits a request. Returns its number, which its response has.
    pub fn call(&self, client: usize, message: Vec<u8>) -> i64 {
        self.0.call(client, message)
    }

    /// Takes the oldest outcome of this client's requests.
    pub fn take_response(&self, client: usize) -> Option<Response> {
        self.0.take_response(client)
    }

    /// Returns the state of the connection, and the failed attempts since it was last connected.
    pub fn state(&self) -> (NodeState, u32) {
        self.0.state()
    }

    /// Takes the remarks on other nodes.
    pub fn remarks(&self) -> Vec<String> {
        self.0.remarks()
    }

    /// Ends the node after the submitted messages are sent, and waits for that for 300 ms at most.
    pub fn close(&self) {
        if self.0.sends {
            self.0.finish(CLOSE_TIMEOUT);
        }
    }
}

impl Drop for Node {
    fn drop(&mut self) {
        self.0.finish(Duration::ZERO);
    }
}
