//! The thread that answers queries and publishes everything but values. It runs at the link's niceness and
//! takes none of the application's locks before the link ends. It bounds the requests of clients: excess is
//! dropped, and the reply to an invalid request contains the reason.

use std::sync::Arc;
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use jde_board::VariableStatus;
use jde_records::RecordKind;
use jde_records::snapshot::Snapshot;
use serde::Serialize;
use zenoh::Wait;
use zenoh::bytes::ZBytes;
use zenoh::key_expr::KeyExpr;
use zenoh::query::Query;

use super::bucket::TokenBucket;
use super::cached_reply::CachedReply;
use super::description::variable_info;
use super::events::EventHistory;
use super::inbox::{Inbox, Origin, QueuedQuery, is_operate_key};
use super::leases::Leases;
use super::operator_workers::{Job, JobOutcome, OperatorRequest, OperatorWorkers};
use super::server_session::ServerSession;
use super::subject::Subject;
use super::value_reader::ValueReader;
use crate::decode::{self, Refused};
use crate::keys::{self, Keys};
use crate::message::{About, Action, Network, OperateReply, Refusal, Request, VariableInfo};

/// Polling interval for events, with and without subscribers.
const ACTIVE_POLL: Duration = Duration::from_millis(20);
const IDLE_POLL: Duration = Duration::from_millis(250);
/// A pause that ends later than this: the process was stopped, or had no time for this thread.
const MIN_STALL: Duration = Duration::from_millis(250);
/// Most queries handled in one round.
const QUERIES_PER_ROUND: usize = 16;
/// Default number of records in the reply to a query for events.
const DEFAULT_EVENTS: usize = 100;
/// Requests to operate per second, from all clients of an origin together: each takes the application's
/// locks.
const REQUESTS_PER_SECOND: f64 = 100.0;

/// Gestures per second, likewise. Dragging sends one for each displayed picture. They are counted separately,
/// so that no panel uses up the allowance for stopping a robot.
const GESTURES_PER_SECOND: f64 = 100.0;

/// The state of the thread.
pub(super) struct Worker {
    pub(super) subject: Arc<dyn Subject>,
    pub(super) inbox: Arc<Inbox>,
    pub(super) keys: Keys,
    pub(super) sessions: Vec<ServerSession>,
    operator_workers: OperatorWorkers,
    history: EventHistory,
    /// Threads that must end before the sessions close.
    threads: Vec<JoinHandle<()>>,
    leases: Leases,
    /// One per origin, so that no origin uses up the other's allowance.
    request_limits: [TokenBucket; 2],
    gesture_limits: [TokenBucket; 2],
    about: JsonMessage,
    network: Network,
    schemas: JsonMessage,
    /// The members of all groups without a father.
    roots: Vec<String>,
    variables: Vec<VariableInfo>,
    plain_variables: JsonMessage,
    readers: Vec<Option<ValueReader>>,
    hierarchy: CachedReply,
    statuses: CachedReply,
}

/// A message in JSON.
pub(super) type JsonMessage = ZBytes;

impl Worker {
    pub(super) fn new(
        subject: Arc<dyn Subject>,
        inbox: Arc<Inbox>,
        keys: Keys,
        about: &About,
        sessions: Vec<ServerSession>,
        operator_workers: OperatorWorkers,
        history: EventHistory,
    ) -> Self {
        let board: Vec<_> = subject.board().list().collect();
        let variables: Vec<_> = board
            .iter()
            .map(|variable| variable_info(&*subject, variable))
            .collect();
        let schemas = subject.schemas();
        let root_groups = schemas.groups.iter().filter(|group| group.father.is_none());
        Self {
            roots: root_groups.flat_map(|group| group.members.clone()).collect(),
            schemas: json(&schemas),
            plain_variables: json(&variables),
            readers: board.iter().map(|_| None).collect(),
            variables,
            about: json(about),
            network: about.network,
            request_limits: std::array::from_fn(|_| TokenBucket::new(REQUESTS_PER_SECOND, Instant::now())),
            gesture_limits: std::array::from_fn(|_| TokenBucket::new(GESTURES_PER_SECOND, Instant::now())),
            subject,
            inbox,
            keys,
            sessions,
            operator_workers,
            history,
            threads: Vec::new(),
            leases: Leases::default(),
            hierarchy: CachedReply::default(),
            statuses: CachedReply::default(),
        }
    }

    /// Sets threads to join before the sessions close.
    pub(super) fn with_threads(self, threads: Vec<JoinHandle<()>>) -> Self {
        Self { threads, ..self }
    }

    /// Works until the link stops, then ends all leases and closes the sessions.
    pub(super) fn run(mut self) {
        while !self.inbox.is_stopping() {
            let next = self.round();
            if self.inbox.is_idle() {
                std::thread::park_timeout(next.saturating_duration_since(Instant::now()));
                let late = Instant::now().saturating_duration_since(next);
                if late > MIN_STALL {
                    self.leases.extend(late);
                }
            }
        }
        self.publish_events();
        for request in self.leases.take_all() {
            let _ = self.subject.operate(&request);
        }
        drop((self.hierarchy, self.statuses));
        for thread in self.threads {
            let _ = thread.join();
        }
        self.sessions.into_iter().for_each(ServerSession::close);
    }

    /// Does all pending work. Returns the time of the next round.
    fn round(&mut self) -> Instant {
        self.publish_events();
        let inbox = Arc::clone(&self.inbox);
        for queue in [&inbox.stop_outcomes, &inbox.outcomes] {
            for _ in 0..queue.len() {
                if let Some(outcome) = queue.pop() {
                    self.handle_outcome(outcome);
                }
            }
        }
        self.end_leases();
        for number in 0..QUERIES_PER_ROUND {
            // One query per round takes precedence, so that endless requests do not block queries.
            let Some(query) = self.inbox.next_query(number == 0) else {
                break;
            };
            self.handle_query(query);
        }
        let is_watched = self
            .sessions
            .iter()
            .any(|session| session.hierarchy.has_subscribers());
        let next_snapshot = (is_watched || self.hierarchy.is_awaited())
            .then(|| self.fetch(true))
            .flatten();
        let next_statuses = self.statuses.is_awaited().then(|| self.fetch(false)).flatten();
        let has_subscribers = RecordKind::ALL.iter().any(|kind| {
            self.sessions
                .iter()
                .any(|session| session.events(*kind).has_subscribers())
        });
        let now = Instant::now();
        let next_poll = now + if has_subscribers { ACTIVE_POLL } else { IDLE_POLL };
        [next_snapshot, next_statuses, self.leases.next()]
            .into_iter()
            .flatten()
            .fold(next_poll, Instant::min)
    }

    fn publish_events(&mut self) {
        let sessions = &self.sessions;
        self.history.process(|kind, record| {
            for session in sessions
                .iter()
                .filter(|session| session.events(kind).has_subscribers())
            {
                let number = record.number.to_le_bytes().to_vec();
                session
                    .events(kind)
                    .put(record.record.to_json().into(), Some(number));
            }
        });
    }

    /// Fetches a snapshot or the variables' statuses, unless it is too early; returns when to try again.
    fn fetch(&mut self, snapshot: bool) -> Option<Instant> {
        let (reply, job) = if snapshot {
            (&mut self.hierarchy, Job::Snapshot)
        } else {
            (&mut self.statuses, Job::Statuses)
        };
        reply.fetch(|| self.operator_workers.send(job).is_ok())
    }

    fn handle_outcome(&mut self, outcome: JobOutcome) {
        if !matches!(outcome, JobOutcome::Snapshot(_) | JobOutcome::Statuses(_)) {
            self.hierarchy.outdate();
            self.statuses.outdate();
        }
        match outcome {
            JobOutcome::Snapshot(snapshot) => self.publish_snapshot(&snapshot),
            JobOutcome::Statuses(statuses) => self.publish_statuses(&statuses),
            JobOutcome::Operated(operated, outcome) => {
                self.operator_workers.finish(&operated);
                if outcome.is_ok() {
                    self.leases.record(&operated.request, Instant::now());
                }
                if let Some(query) = operated.query {
                    let is_global = operated.request.action.is_global();
                    let roots = if is_global { self.roots.clone() } else { Vec::new() };
                    self.reply_outcome(&query, outcome.map(|losses| (losses, roots)));
                }
            }
            JobOutcome::Released(operated, outcome) => {
                self.operator_workers.finish(&operated);
                if let Some(query) = operated.query {
                    let released = |stopped: Vec<String>| {
                        let roots = self.roots.iter().filter(|root| stopped.contains(root));
                        (String::new(), roots.cloned().collect())
                    };
                    self.reply_outcome(&query, outcome.map(released));
                }
            }
            JobOutcome::Stopped(queries, outcome) => {
                for query in queries {
                    let outcome = outcome.clone().map(|()| (String::new(), self.roots.clone()));
                    self.reply_outcome(&query, outcome);
                }
            }
            JobOutcome::Reloaded(operated, outcome) => {
                if let Some(query) = operated.query {
                    match outcome {
                        Ok(reloaded) => {
                            let message = OperateReply {
                                ok: true,
                                reloaded: Some(reloaded),
                                ..OperateReply::default()
                            };
                            reply(&query, &self.keys.of(keys::OPERATE), json(&message));
                        }
                        Err(refusal) => refuse(&query, &refusal),
                    }
                }
            }
        }
    }

    /// Replies with what awake schemas lose, and with the roots that were stopped or released at once.
    fn reply_outcome(&self, query: &Query, outcome: Result<(String, Vec<String>), Refusal>) {
        match outcome {
            Ok((losses, roots)) => {
                let message = OperateReply {
                    ok: true,
                    losses,
                    roots,
                    ..OperateReply::default()
                };
                reply(query, &self.keys.of(keys::OPERATE), json(&message));
            }
            Err(refusal) => refuse(query, &refusal),
        }
    }

    fn publish_snapshot(&mut self, snapshot: &Snapshot) {
        let message = json(snapshot);
        let key = self.keys.of(keys::HIERARCHY);
        self.hierarchy.complete(&key, message.clone());
        for session in self
            .sessions
            .iter()
            .filter(|session| session.hierarchy.has_subscribers())
        {
            session.hierarchy.put(message.clone(), None);
        }
    }

    fn publish_statuses(&mut self, statuses: &[VariableStatus]) {
        let names = |writer: u32| Some(self.subject.writer(writer)).filter(|name| !name.is_empty());
        for (info, status) in self.variables.iter_mut().zip(statuses) {
            info.status = Some(crate::message::Status {
                sequence: status.sequence,
                age_s: status.age.map(|age| age as f64 / 1e9),
                rate_hz: status.rate_hz,
                retracted: status.ended,
                last_writer: status.last_writer.and_then(names),
                writers: status.writers.clone(),
                readers: status.readers.clone(),
                refused: status.refused,
                not_finite: status.not_finite,
            });
        }
        let message = json(&self.variables);
        self.statuses.complete(&self.keys.of(keys::VARIABLES), message);
    }

    fn end_leases(&mut self) {
        let now = Instant::now();
        for request in self.leases.take_expired(now) {
            let release = OperatorRequest { request, query: None };
            if let Err(Job::Operate(refused)) = self.operator_workers.send(Job::Operate(Box::new(release))) {
                self.leases.retry(&refused.request, now);
            }
        }
    }

    /// Sends a separate reply for each of the application's keys that a query matches.
    fn handle_query(&mut self, queued: QueuedQuery) {
        let QueuedQuery { origin, queue, query } = queued;
        let key = query.key_expr().clone();
        let matches = |own_key: &str| matches_key(&key, own_key);
        let keys = self.keys.clone();
        let of = |path: &str| keys.of(path);
        for (path, message) in [(keys::ABOUT, &self.about), (keys::SCHEMAS, &self.schemas)] {
            if matches(&of(path)) {
                reply(&query, &of(path), message.clone());
            }
        }
        for kind in RecordKind::ALL {
            let events = of(keys::events(kind));
            if matches(&events) {
                let count = parameter(&query, "last").unwrap_or(DEFAULT_EVENTS);
                reply(&query, &events, self.history.last(kind, count).into());
            }
        }
        if matches(&of("var/*/*")) {
            self.reply_values(&query, &key);
        }
        // These keep the query until there is a reply, so only one of them can take it.
        if is_operate_key(&key) {
            if matches(&of(keys::OPERATE)) {
                self.operate(origin, query);
            }
        } else if matches(&of(keys::HIERARCHY)) {
            self.hierarchy.query(query, &of(keys::HIERARCHY), queue);
        } else if matches(&of(keys::VARIABLES)) {
            if query.parameters().contains_key("status") {
                self.statuses.query(query, &of(keys::VARIABLES), queue);
            } else {
                reply(&query, &of(keys::VARIABLES), self.plain_variables.clone());
            }
        }
    }

    fn reply_values(&mut self, query: &Query, key: &KeyExpr<'_>) {
        for (index, info) in self.variables.iter().enumerate() {
            let variable = self.keys.variable(&info.owner, &info.variable);
            if !matches_key(key, &variable) {
                continue;
            }
            if self.readers[index].is_none() {
                let found = self.subject.board().find(&info.name);
                self.readers[index] = found.map(|variable| ValueReader::new(&variable));
            }
            let Some(reader) = &mut self.readers[index] else {
                continue;
            };
            if let Some((tag, value)) = reader.newest(&*self.subject, None) {
                let sent = query.reply(variable, value).attachment(tag.bytes()).wait();
                if let Err(error) = sent {
                    tracing::debug!("a reply was not sent: {error}");
                }
            }
        }
    }

    fn operate(&mut self, origin: Origin, query: Query) {
        if origin == Origin::Network
            && let Err(refusal) = may_operate(self.network)
        {
            return refuse(&query, &refusal);
        }
        let request = match parse_query(&query) {
            Ok(request) => request,
            Err(refusal) => return refuse(&query, &refusal),
        };
        // A request for one schema must be addressed to one application.
        if query.key_expr().as_str() != self.keys.of(keys::OPERATE) && !request.action.is_global() {
            return;
        }
        if let Err(refusal) = self.leases.check(&request) {
            return refuse(&query, &refusal);
        }
        let busy = Refusal::new("the application receives too many requests; try again");
        let bucket = match request.action {
            Action::Touch { .. } => &mut self.gesture_limits[origin as usize],
            _ => &mut self.request_limits[origin as usize],
        };
        if !bucket.try_take(Instant::now()) {
            return refuse(&query, &busy);
        }
        let reload = matches!(request.action, Action::Reload { .. });
        let operation = Box::new(OperatorRequest {
            request,
            query: Some(query),
        });
        let job = if reload {
            Job::Reload(operation)
        } else {
            Job::Operate(operation)
        };
        if let Err(Job::Operate(refused) | Job::Reload(refused)) = self.operator_workers.send(job)
            && let Some(query) = &refused.query
        {
            refuse(query, &busy);
        }
    }
}

/// Refuses clients on the network unless they may operate.
pub(super) fn may_operate(network: Network) -> Result<(), Refusal> {
    match network {
        Network::Operate => Ok(()),
        Network::Closed | Network::Read => Err(Refusal::new(
            "clients from the network may only read; operate on the machine itself, or set `access = \"operate\"` in the application",
        )),
    }
}

/// Whether a query matches a key.
pub(super) fn matches_key(query: &KeyExpr<'_>, key: &str) -> bool {
    KeyExpr::new(key).is_ok_and(|key| query.intersects(&key))
}

fn parameter(query: &Query, name: &str) -> Option<usize> {
    query.parameters().get(name)?.parse().ok()
}

/// Reads a request to `operate` from a query.
pub(super) fn parse_query(query: &Query) -> Result<Request, Refusal> {
    let payload = query
        .payload()
        .ok_or_else(|| Refusal::new("the request is empty; it must be a message in JSON"))?;
    read_request(&payload.to_bytes())
}

/// Reads an untrusted request in JSON.
pub(super) fn read_request(bytes: &[u8]) -> Result<Request, Refusal> {
    decode::request(bytes).map_err(|refused| {
        let (Refused::Unreadable(reason) | Refused::Nonsense(reason)) = refused;
        Refusal::new(format!("the request is not valid: {reason}"))
    })
}

pub(super) fn reply(query: &Query, key: &str, message: JsonMessage) {
    if let Err(error) = query.reply(key, message).wait() {
        tracing::debug!("a reply was not sent: {error}");
    }
}

fn refuse(query: &Query, refusal: &Refusal) {
    if let Err(error) = query.reply_err(json(refusal)).wait() {
        tracing::debug!("a reply was not sent: {error}");
    }
}

/// Converts a message to JSON, which cannot fail for numbers, texts and lists of them.
fn json(message: &impl Serialize) -> JsonMessage {
    ZBytes::from(serde_json::to_vec(message).unwrap_or_default())
}
