//! The thread that answers queries and publishes everything but values. It runs at the link's niceness and
//! takes none of the application's locks before the link ends. It bounds what clients send: excess is
//! dropped, and invalid requests get an answer with the reason.

use std::sync::Arc;
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use jde_board::{Reader, VariableStatus};
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
use super::inbox::{Inbox, Origin, QueuedQuery, is_order};
use super::leases::Leases;
use super::operator_workers::{Job, JobOutcome, OperatorRequest, OperatorWorkers};
use super::server_session::ServerSession;
use super::subject::Subject;
use super::value_publisher;
use crate::keys::{self, Keys};
use crate::message::{About, Action, Network, OperateReply, Refusal, Request, VariableInfo};

/// Polling interval for events, with and without subscribers.
const ACTIVE_POLL: Duration = Duration::from_millis(20);
const IDLE: Duration = Duration::from_millis(250);
/// Most requests answered between two rounds of other work.
const ROUND: usize = 16;
/// Longest request to `operate`, bytes: the largest modulations are parameters and paths.
const MAX_REQUEST_BYTES: usize = 1 << 20;
/// Default number of lines in the answer to a query for events.
const USUAL: usize = 100;
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
    readers: Vec<Option<Reader>>,
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
        let tops = schemas.groups.iter().filter(|group| group.father.is_none());
        Self {
            roots: tops.flat_map(|group| group.members.clone()).collect(),
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
            }
        }
        self.publish_events();
        for request in self.leases.take_all() {
            let _ = self.subject.act(&request.by, &request.action);
        }
        drop((self.hierarchy, self.statuses));
        for other in self.threads {
            let _ = other.join();
        }
        self.sessions.into_iter().for_each(ServerSession::close);
    }

    /// Does all pending work; returns when the next is due.
    fn round(&mut self) -> Instant {
        self.publish_events();
        let inbox = Arc::clone(&self.inbox);
        for queue in [&inbox.stop_outcomes, &inbox.outcomes] {
            for _ in 0..queue.len() {
                if let Some(done) = queue.pop() {
                    self.handle_outcome(done);
                }
            }
        }
        self.end_leases();
        for place in 0..ROUND {
            // One query per round takes precedence, so that endless orders do not block queries.
            let Some(ask) = self.inbox.next_query(place == 0) else {
                break;
            };
            self.handle_query(ask);
        }
        let looked_at = self.sessions.iter().any(|door| door.hierarchy.has_subscribers());
        let next_snapshot = (looked_at || self.hierarchy.is_awaited())
            .then(|| self.fetch(true))
            .flatten();
        let next_look = self.statuses.is_awaited().then(|| self.fetch(false)).flatten();
        let listening = RecordKind::ALL.iter().any(|kind| {
            self.sessions
                .iter()
                .any(|door| door.events(*kind).has_subscribers())
        });
        let now = Instant::now();
        let look = now + if listening { ACTIVE_POLL } else { IDLE };
        [next_snapshot, next_look, self.leases.next()]
            .into_iter()
            .flatten()
            .fold(look, Instant::min)
    }

    fn publish_events(&mut self) {
        let doors = &self.sessions;
        self.history.process(|kind, line| {
            for door in doors.iter().filter(|door| door.events(kind).has_subscribers()) {
                let number = line.number.to_le_bytes().to_vec();
                door.events(kind).put(line.record.to_json().into(), Some(number));
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

    fn handle_outcome(&mut self, done: JobOutcome) {
        if !matches!(done, JobOutcome::Snapshot(_) | JobOutcome::Statuses(_)) {
            self.hierarchy.outdate();
            self.statuses.outdate();
        }
        match done {
            JobOutcome::Snapshot(snapshot) => self.publish_snapshot(&snapshot),
            JobOutcome::Statuses(statuses) => self.publish_statuses(&statuses),
            JobOutcome::Operated(act, outcome) => {
                self.operator_workers.finish(&act);
                if outcome.is_ok() {
                    self.leases.record(&act.request, Instant::now());
                }
                if let Some(query) = act.query {
                    let everything = act.request.action.is_global();
                    self.reply_outcome(&query, outcome, everything);
                }
            }
            JobOutcome::Stopped(queries, outcome) => {
                for query in queries {
                    self.reply_outcome(&query, outcome.clone(), true);
                }
            }
            JobOutcome::Reloaded(act, outcome) => {
                if let Some(query) = act.query {
                    match outcome {
                        Ok(reloaded) => {
                            let fine = OperateReply {
                                ok: true,
                                reloaded: Some(reloaded),
                                ..OperateReply::default()
                            };
                            reply(&query, &self.keys.of(keys::OPERATE), json(&fine));
                        }
                        Err(refusal) => refuse(&query, &refusal),
                    }
                }
            }
        }
    }

    fn reply_outcome(&self, query: &Query, outcome: Result<(), Refusal>, everything: bool) {
        match outcome {
            Ok(()) => {
                let fine = OperateReply {
                    ok: true,
                    roots: if everything {
                        self.roots.clone()
                    } else {
                        Vec::new()
                    },
                    ..OperateReply::default()
                };
                reply(query, &self.keys.of(keys::OPERATE), json(&fine));
            }
            Err(refusal) => refuse(query, &refusal),
        }
    }

    fn publish_snapshot(&mut self, snapshot: &Snapshot) {
        let message = json(snapshot);
        let key = self.keys.of(keys::HIERARCHY);
        self.hierarchy.complete(&key, message.clone());
        for door in self
            .sessions
            .iter()
            .filter(|door| door.hierarchy.has_subscribers())
        {
            door.hierarchy.put(message.clone(), None);
        }
    }

    fn publish_statuses(&mut self, statuses: &[VariableStatus]) {
        let names = |writer: u32| Some(self.subject.writer(writer)).filter(|name| !name.is_empty());
        for (info, status) in self.variables.iter_mut().zip(statuses) {
            info.status = Some(crate::message::Status {
                sequence: status.sequence,
                age_s: status.age.map(|age| age as f64 / 1e9),
                rate_hz: status.rate_hz,
                retracted: status.retracted,
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
            let act = OperatorRequest { request, query: None };
            if let Err(Job::Operate(act)) = self.operator_workers.send(Job::Operate(Box::new(act))) {
                self.leases.retry(&act.request, now);
            }
        }
    }

    /// Answers all parts of the application that a query matches, each separately.
    fn handle_query(&mut self, ask: QueuedQuery) {
        let QueuedQuery {
            origin,
            queue: line,
            query,
        } = ask;
        let key = query.key_expr().clone();
        let asked = |what: &str| matches_key(&key, what);
        let keys = self.keys.clone();
        let of = |what: &str| keys.of(what);
        for (what, answer) in [(keys::ABOUT, &self.about), (keys::SCHEMAS, &self.schemas)] {
            if asked(&of(what)) {
                reply(&query, &of(what), answer.clone());
            }
        }
        for kind in RecordKind::ALL {
            let events = of(keys::events(kind));
            if asked(&events) {
                let count = parameter(&query, "last").unwrap_or(USUAL);
                reply(&query, &events, self.history.last(kind, count).into());
            }
        }
        if asked(&of("var/*/*")) {
            self.reply_values(&query, &key);
        }
        // These keep the query until there is an answer, so only one of them can get it.
        if is_order(&key) {
            if asked(&of(keys::OPERATE)) {
                self.operate(origin, query);
            }
        } else if asked(&of(keys::HIERARCHY)) {
            self.hierarchy.query(query, &of(keys::HIERARCHY), line);
        } else if asked(&of(keys::VARIABLES)) {
            if query.parameters().contains_key("status") {
                self.statuses.query(query, &of(keys::VARIABLES), line);
            } else {
                reply(&query, &of(keys::VARIABLES), self.plain_variables.clone());
            }
        }
    }

    fn reply_values(&mut self, query: &Query, key: &KeyExpr<'_>) {
        for (place, info) in self.variables.iter().enumerate() {
            let variable = self.keys.variable(&info.owner, &info.variable);
            if !matches_key(key, &variable) {
                continue;
            }
            if self.readers[place].is_none() {
                let found = self.subject.board().find(&info.name);
                self.readers[place] = found.map(|variable| variable.reader("link"));
            }
            let Some(reader) = &mut self.readers[place] else {
                continue;
            };
            if let (Some(tag), value) = value_publisher::newest(reader, &*self.subject, None) {
                let sent = query.reply(variable, value).attachment(tag.bytes()).wait();
                if let Err(error) = sent {
                    tracing::debug!("an answer was not sent: {error}");
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
        // An order for one schema must be addressed to one application.
        if query.key_expr().as_str() != self.keys.of(keys::OPERATE) && !request.action.is_global() {
            return;
        }
        if let Err(refusal) = self.leases.check(&request) {
            return refuse(&query, &refusal);
        }
        let busy = Refusal::new("too much is asked of the application at once; try again");
        let bucket = match request.action {
            Action::Touch { .. } => &mut self.gesture_limits[origin as usize],
            _ => &mut self.request_limits[origin as usize],
        };
        if !bucket.try_take(Instant::now()) {
            return refuse(&query, &busy);
        }
        let reload = matches!(request.action, Action::Reload { .. });
        let act = Box::new(OperatorRequest {
            request,
            query: Some(query),
        });
        let errand = if reload {
            Job::Reload(act)
        } else {
            Job::Operate(act)
        };
        if let Err(Job::Operate(act) | Job::Reload(act)) = self.operator_workers.send(errand)
            && let Some(query) = &act.query
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
            "clients from the network may only look; operate on the machine itself, or let the application say `access = \"operate\"`",
        )),
    }
}

/// Whether a query matches a key.
pub(super) fn matches_key(question: &KeyExpr<'_>, key: &str) -> bool {
    KeyExpr::new(key).is_ok_and(|key| question.intersects(&key))
}

fn parameter(query: &Query, name: &str) -> Option<usize> {
    query.parameters().get(name)?.parse().ok()
}

/// Reads a request to `operate` from a query.
pub(super) fn parse_query(query: &Query) -> Result<Request, Refusal> {
    let payload = query
        .payload()
        .ok_or_else(|| Refusal::new("a request is a message in JSON; there is none"))?;
    read_request(&payload.to_bytes())
}

/// Reads an untrusted request in JSON.
pub(super) fn read_request(bytes: &[u8]) -> Result<Request, Refusal> {
    if bytes.len() > MAX_REQUEST_BYTES {
        return Err(Refusal::new(format!(
            "a request has at most {MAX_REQUEST_BYTES} bytes"
        )));
    }
    serde_json::from_slice(bytes).map_err(|error| Refusal::new(format!("no request: {error}")))
}

pub(super) fn reply(query: &Query, key: &str, message: JsonMessage) {
    if let Err(error) = query.reply(key, message).wait() {
        tracing::debug!("an answer was not sent: {error}");
    }
}

fn refuse(query: &Query, refusal: &Refusal) {
    if let Err(error) = query.reply_err(json(refusal)).wait() {
        tracing::debug!("an answer was not sent: {error}");
    }
}

/// Serialisation cannot fail for numbers, texts and lists of them.
fn json(message: &impl Serialize) -> JsonMessage {
    ZBytes::from(serde_json::to_vec(message).unwrap_or_default())
}
