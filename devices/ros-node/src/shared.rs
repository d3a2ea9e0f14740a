//! The state shared by the owner of a node, the node's thread and Zenoh's threads. No thread holds a lock
//! for which the owner waits while it waits for the network.

use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use parking_lot::{Condvar, Mutex};
use zenoh::bytes::ZBytes;
use zenoh::sample::Sample;

use crate::attachment::{Gid, parse};
use crate::keys::{Announced, Direction, Topic, missing};
use crate::node::{Arrival, NodeConfig, NodeState, ReceivedMessage};
use crate::outbox::Outbox;
use crate::own::OwnCommands;
use crate::publishers::Publishers;
use crate::requests::Requests;
use crate::send_queue::{Meeting, SendQueue, Work};
use crate::services::{Request, Response};
use crate::sources::{Acceptance, Sources};

/// Most remarks per node. They are remembered so that none is repeated.
const MAX_REMARKS: usize = 64;
/// Most requests or responses of one service that wait, but for the urgent one. Further requests are refused; further responses replace the
/// oldest.
pub(crate) const MAX_WAITING: usize = 10;
/// Most publications of a latched topic whose order is known.
const MAX_SOURCES: usize = 256;

/// Submitted messages, arrived messages and status.
#[derive(Debug)]
pub(crate) struct Shared {
    queue: Mutex<SendQueue>,
    pub(crate) publishers: Publishers,
    changed: Condvar,
    subscribed: Vec<AtomicBool>,
    /// Whether messages of each publication and of each subscription pass: to a bridge, those of one type of a topic.
    passing: [Vec<AtomicBool>; 2],
    /// The bytes at the end of each publication's messages that are not sent.
    missing: Vec<usize>,
    arrived: Vec<Mutex<Inbox>>,
    pub(crate) requests: Requests,
    /// Whether the owner wants the messages of each subscription.
    wanted: Vec<AtomicBool>,
    clients: Vec<Mutex<ClientState>>,
    /// Whether the node sends anything: messages, requests or responses.
    pub(crate) sends: bool,
    arrival: Arrival,
    status: Mutex<NodeStatus>,
}

/// The messages of a subscription that were not taken.
#[derive(Debug)]
struct Inbox {
    messages: VecDeque<ReceivedMessage>,
    depth: usize,
    is_latched: bool,
    /// Its topic, if its messages command a robot.
    commands: Option<String>,
    /// See [`ReceivedMessage`].
    missing: &'static [u8],
    /// Its name and publications, if one node alone sends its messages.
    sources: Option<(String, Sources)>,
    /// The numbers of the newest messages of a latched topic, by publication.
    newest: BTreeMap<Gid, i64>,
}

#[derive(Debug, Default)]
struct ClientState {
    last_sequence: i64,
    responses: VecDeque<Response>,
    /// The tokens of the nodes that offer its service.
    servers: BTreeSet<String>,
}

#[derive(Debug)]
struct NodeStatus {
    state: NodeState,
    attempts: u32,
    remarks: Vec<String>,
    past_remarks: Vec<String>,
}

impl Shared {
    pub(crate) fn new(config: &NodeConfig) -> Self {
        let publications = &config.publications;
        let passes_first = |topic: &Topic| !config.name.is_bridged() || topic.announced != Announced::OnceMet;
        Self {
            queue: Mutex::new(SendQueue::new(publications)),
            publishers: Publishers::default(),
            changed: Condvar::new(),
            subscribed: publications.iter().map(|_| AtomicBool::new(false)).collect(),
            passing: [publications, &config.subscriptions].map(|topics| {
                topics
                    .iter()
                    .map(|topic| AtomicBool::new(passes_first(topic)))
                    .collect()
            }),
            missing: publications
                .iter()
                .map(|topic| missing(&config.name, topic).len())
                .collect(),
            arrived: config
                .subscriptions
                .iter()
                .map(|topic| {
                    Mutex::new(Inbox {
                        messages: VecDeque::new(),
                        depth: topic.quality.depth,
                        is_latched: topic.quality.latched,
                        commands: topic.is_command.then(|| topic.name.clone()),
                        missing: missing(&config.name, topic),
                        sources: topic
                            .has_one_source
                            .then(|| (topic.name.clone(), Sources::default())),
                        newest: BTreeMap::new(),
                    })
                })
                .collect(),
            requests: Requests::new(config.urgent_service),
            wanted: config
                .subscriptions
                .iter()
                .map(|topic| AtomicBool::new(topic.announced != Announced::WhileWanted))
                .collect(),
            clients: config.clients.iter().map(|_| Mutex::default()).collect(),
            sends: !(publications.is_empty() && config.clients.is_empty() && config.services.is_empty()),
            arrival: config.arrival.clone(),
            status: Mutex::new(NodeStatus {
                state: NodeState::Connecting,
                attempts: 0,
                remarks: Vec::new(),
                past_remarks: Vec::new(),
            }),
        }
    }

    pub(crate) fn has_subscribers(&self, publication: usize) -> bool {
        self.subscribed[publication].load(Ordering::Relaxed)
            && self.passing[0][publication].load(Ordering::Relaxed)
    }

    /// Sets whether messages of a topic pass. Those of a service always do.
    pub(crate) fn set_passing(&self, (direction, number): (Direction, usize), is_passing: bool) {
        let topics = match direction {
            Direction::Publish => &self.passing[0],
            Direction::Subscribe => &self.passing[1],
            Direction::Serve | Direction::Call => return,
        };
        topics[number].store(is_passing, Ordering::Relaxed);
    }

    pub(crate) fn has_sent(&self, publication: usize) -> bool {
        self.queue.lock().outboxes[publication].is_empty()
    }

    pub(crate) fn is_waiting(&self, publication: usize) -> bool {
        let mut queue = self.queue.lock();
        let is_waiting = !queue.outboxes[publication].is_empty();
        queue.is_awaited |= is_waiting;
        is_waiting
    }

    /// Sends a message at once, or submits messages and replaces those that were not sent yet.
    pub(crate) fn publish(&self, publication: usize, mut messages: Vec<Vec<u8>>) {
        messages
            .iter_mut()
            .for_each(|message| self.shorten(publication, message));
        if messages.len() == 1 && self.sends_at_once(publication, &mut messages[0]) {
            return;
        }
        self.queue.lock().outboxes[publication].replace(messages);
        self.changed.notify_one();
    }

    /// Sends a message at once, or submits it after those that wait, up to the depth of the publication.
    pub(crate) fn append(&self, publication: usize, mut message: Vec<u8>) {
        self.shorten(publication, &mut message);
        if self.sends_at_once(publication, &mut message) {
            return;
        }
        self.queue.lock().outboxes[publication].append(message);
        self.changed.notify_one();
    }

    /// Removes what the messages of a publication do not have where the node connects.
    fn shorten(&self, publication: usize, message: &mut Vec<u8>) {
        message.truncate(message.len().saturating_sub(self.missing[publication]));
    }

    /// Whether it has sent the message: a small one, if none of this publication waits and the thread does not send.
    fn sends_at_once(&self, publication: usize, message: &mut Vec<u8>) -> bool {
        let sending = self.publishers.at_once(message);
        let Some(mut sending) = sending.filter(|_| self.has_sent(publication)) else {
            return false;
        };
        sending.put(publication, std::mem::take(message));
        true
    }

    /// Submits a request. Returns its number.
    pub(crate) fn call(&self, client: usize, message: Vec<u8>) -> i64 {
        let sequence = {
            let mut state = self.clients[client].lock();
            state.last_sequence += 1;
            state.last_sequence
        };
        self.queue.lock().calls.push((client, sequence, message));
        self.changed.notify_one();
        sequence
    }

    /// Submits a response, or the reason why there is none.
    pub(crate) fn reply(&self, request: Request, response: Result<Vec<u8>, String>) {
        self.queue.lock().replies.push((request, response));
        self.changed.notify_one();
    }

    /// Takes all messages of a subscription that wait, the oldest first.
    pub(crate) fn take_all(&self, subscription: usize) -> VecDeque<ReceivedMessage> {
        std::mem::take(&mut self.arrived[subscription].lock().messages)
    }

    /// Whether the owner wants the messages of a subscription.
    pub(crate) fn is_wanted(&self, subscription: usize) -> bool {
        self.wanted[subscription].load(Ordering::Relaxed)
    }

    /// Sets whether the owner wants them.
    pub(crate) fn want(&self, subscription: usize, is_wanted: bool) {
        if self.wanted[subscription].swap(is_wanted, Ordering::Relaxed) != is_wanted {
            self.arrived[subscription].lock().messages.clear();
            self.queue.lock().is_rewired = true;
            self.changed.notify_one();
        }
    }

    /// Whether several nodes send the messages of a subscription that has one source.
    pub(crate) fn is_contradicted(&self, subscription: usize) -> bool {
        let mut inbox = self.arrived[subscription].lock();
        let sources = inbox.sources.as_mut();
        sources.is_some_and(|(_, sources)| sources.contradict(Instant::now()))
    }

    /// Records that a publication of a subscription's topic begins, with the name of its node, or ends.
    pub(crate) fn set_source(&self, subscription: usize, publication: Gid, name: Option<String>) {
        if let Some((_, sources)) = &mut self.arrived[subscription].lock().sources {
            match name {
                Some(name) => sources.appear(publication, name),
                None => sources.disappear(publication),
            }
        }
    }

    pub(crate) fn take_response(&self, client: usize) -> Option<Response> {
        self.clients[client].lock().responses.pop_front()
    }

    pub(crate) fn has_server(&self, client: usize) -> bool {
        !self.clients[client].lock().servers.is_empty()
    }

    pub(crate) fn state(&self) -> (NodeState, u32) {
        let status = self.status.lock();
        (status.state.clone(), status.attempts)
    }

    pub(crate) fn remarks(&self) -> Vec<String> {
        std::mem::take(&mut self.status.lock().remarks)
    }

    /// Requests the end of the thread, and waits for that for at most `timeout`.
    pub(crate) fn finish(&self, timeout: Duration) {
        let mut queue = self.queue.lock();
        queue.ending = true;
        self.changed.notify_one();
        let until = Instant::now() + timeout;
        while !queue.ended {
            let remaining = until.saturating_duration_since(Instant::now());
            if remaining.is_zero() {
                break;
            }
            self.changed.wait_for(&mut queue, remaining);
        }
    }

    /// Returns the work to do. Waits for some for at most `timeout`.
    pub(crate) fn work(&self, timeout: Duration) -> Work {
        let mut queue = self.queue.lock();
        let pause = queue.pause(timeout);
        if !pause.is_zero() {
            self.changed.wait_for(&mut queue, pause);
        }
        let met = std::mem::take(&mut queue.met);
        let calls = std::mem::take(&mut queue.calls);
        let replies = std::mem::take(&mut queue.replies);
        let caches = std::mem::take(&mut queue.caches);
        let is_rewired = std::mem::take(&mut queue.is_rewired);
        Work {
            met,
            calls,
            replies,
            caches,
            is_rewired,
            ending: queue.ending,
        }
    }

    /// Sends the messages that wait and are due; all of them at the end.
    pub(crate) fn send_waiting(&self, is_ending: bool) {
        // First this lock, so that no later message of the owner goes before those taken here.
        let mut sending = self.publishers.wait();
        let now = Instant::now();
        let take = |outbox: &mut Outbox| outbox.take(now, is_ending);
        let mut queue = self.queue.lock();
        let batches: Vec<_> = queue.outboxes.iter_mut().map(take).collect();
        let is_awaited = std::mem::take(&mut queue.is_awaited);
        drop(queue);
        if is_awaited {
            self.arrival.call();
        }
        for (publication, batch) in batches.into_iter().enumerate() {
            for message in batch {
                sending.put(publication, message);
            }
        }
    }

    /// Reports what another node has in the opposite direction.
    pub(crate) fn meet(&self, meeting: Meeting) {
        self.queue.lock().met.push(meeting);
        self.changed.notify_one();
    }

    /// Waits between two attempts. What was submitted meanwhile is late and is dropped, but for latched messages; a call
    /// gets the outcome that no router answers. Returns whether the node must end instead of trying again.
    pub(crate) fn pause(&self, pause: Duration) -> bool {
        let until = Instant::now() + pause;
        let mut queue = self.queue.lock();
        loop {
            queue.outboxes.iter_mut().for_each(Outbox::drop_volatile);
            queue.replies.clear();
            let calls = std::mem::take(&mut queue.calls);
            for (client, sequence, _) in calls {
                self.respond(client, sequence, Err("no router answers".to_owned()));
            }
            let remaining = until.saturating_duration_since(Instant::now());
            if queue.ending || remaining.is_zero() {
                return queue.ending;
            }
            self.changed.wait_for(&mut queue, remaining);
        }
    }

    pub(crate) fn set_subscribed(&self, publication: usize, subscribed: bool) {
        self.subscribed[publication].store(subscribed, Ordering::Relaxed);
    }

    /// Stores a message. One of the past, from a cache, is dropped if a newer one of its publication came before, and so is
    /// a command of this process.
    pub(crate) fn arrive(&self, subscription: usize, sample: &Sample, is_past: bool) {
        if !self.passing[1][subscription].load(Ordering::Relaxed) || !self.is_wanted(subscription) {
            return;
        }
        let mut inbox = self.arrived[subscription].lock();
        let attachment = sample.attachment().map(ZBytes::to_bytes);
        let source = attachment.as_deref().and_then(parse);
        if let (Some(topic), Some((_, gid))) = (&inbox.commands, source)
            && OwnCommands::contain(gid)
        {
            self.remark(format!(
                "this application publishes {topic} itself, and ignores its own messages: state the topic of another program"
            ));
            return;
        }
        if let (Some((topic, sources)), Some((_, gid))) = (&mut inbox.sources, source) {
            match sources.judge(topic, gid, Instant::now()) {
                Acceptance::Only => {}
                Acceptance::Late => return,
                Acceptance::Contradicted(remark) => {
                    inbox.messages.clear();
                    drop(inbox);
                    if let Some(remark) = remark {
                        self.remark(remark);
                    }
                    // The owner has to end what it has.
                    self.arrival.call_for(subscription);
                    return;
                }
            }
        }
        if let Some((sequence, gid)) = source
            && inbox.is_latched
        {
            if is_past && inbox.newest.get(&gid).is_some_and(|newest| *newest >= sequence) {
                return;
            }
            if inbox.newest.len() >= MAX_SOURCES {
                inbox.newest.clear();
            }
            inbox.newest.insert(gid, sequence);
        }
        if inbox.messages.len() >= inbox.depth {
            inbox.messages.pop_front();
        }
        let missing = inbox.missing;
        inbox.messages.push_back(ReceivedMessage {
            message: sample.payload().clone(),
            received_at: Instant::now(),
            missing,
        });
        drop(inbox);
        self.arrival.call_for(subscription);
    }

    /// Stores a request, or returns it with the number of those that wait, if these are too many.
    pub(crate) fn request(&self, request: Request) -> Option<(Request, usize)> {
        let refused = self.requests.push(request);
        self.arrival.call();
        refused
    }

    /// Stores the outcome of a request of this node.
    pub(crate) fn respond(&self, client: usize, sequence: i64, outcome: Result<Vec<u8>, String>) {
        let mut state = self.clients[client].lock();
        if state.responses.len() >= MAX_WAITING {
            state.responses.pop_front();
        }
        state.responses.push_back(Response { sequence, outcome });
        drop(state);
        self.arrival.call();
    }

    /// Reports that a node begins or ends to offer the service of a client.
    pub(crate) fn set_server(&self, client: usize, token: &str, offers: bool) {
        let mut state = self.clients[client].lock();
        if offers {
            state.servers.insert(token.to_owned());
        } else {
            state.servers.remove(token);
        }
        drop(state);
        self.arrival.call();
    }

    /// Reports a publication that can be queried for its newest messages.
    pub(crate) fn found_cache(&self, subscription: usize, key: String) {
        self.queue.lock().caches.push((subscription, key));
        self.changed.notify_one();
    }

    pub(crate) fn set_state(&self, state: NodeState) {
        let mut status = self.status.lock();
        if state == NodeState::Connected {
            status.attempts = 0;
        }
        status.state = state;
    }

    /// Records a failed attempt.
    pub(crate) fn failed(&self, reason: String) {
        let mut status = self.status.lock();
        status.attempts = status.attempts.saturating_add(1);
        status.state = NodeState::Lost(reason);
    }

    /// Adds a remark on other nodes, unless it is a repetition or there are too many.
    pub(crate) fn remark(&self, remark: String) {
        let mut status = self.status.lock();
        if status.past_remarks.len() < MAX_REMARKS && !status.past_remarks.contains(&remark) {
            status.past_remarks.push(remark.clone());
            status.remarks.push(remark);
        }
    }

    /// Records that the thread ended.
    pub(crate) fn end(&self) {
        self.queue.lock().ended = true;
        self.changed.notify_all();
    }
}
