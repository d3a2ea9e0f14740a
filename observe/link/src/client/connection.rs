//! A client's session to one endpoint. Each endpoint has its own, so that no application there can pose as
//! one elsewhere.

use std::sync::mpsc;
use std::time::{Duration, Instant};

use zenoh::handlers::DefaultHandler;
use zenoh::qos::{CongestionControl, Priority};
use zenoh::query::{ConsolidationMode, QueryTarget};
use zenoh::session::SessionGetBuilder;
use zenoh::{Session, Wait};

use crate::decode::{self, Refused};
use crate::folder::{RunningEntry, new_id};
use crate::message::{About, Refusal};
use crate::session::{self, Login, SessionOptions, Tls};
use crate::{Error, Unanswered};

/// How long a busy socket is retried, and how often.
const RETRY_FOR: Duration = Duration::from_secs(1);
const RETRY_PAUSE: Duration = Duration::from_millis(20);

/// Most replies accepted from one endpoint to one query; bounds endless senders.
const MAX_REPLIES: usize = 256;
/// How long further applications may take to reply after the first.
const NEXT_REPLY_TIMEOUT: Duration = Duration::from_secs(1);

/// A session; closed when dropped, unless another component owns it.
pub(crate) struct Connection {
    session: Option<Session>,
    endpoint: String,
    /// Distinguishes this client's queries from those of others, so that a flood of theirs does not displace
    /// them.
    client: String,
    shared: bool,
    /// Whether it is the private socket of an application on this machine.
    is_private: bool,
}

/// A reply with its attachment.
pub(crate) struct Reply {
    pub(crate) message: Vec<u8>,
    pub(crate) attachment: Option<Vec<u8>>,
}

/// The outcome of a query.
pub(crate) enum QueryOutcome {
    Reply(Reply),
    Refused(Refusal),
    /// The query ended without a reply: no application received it, or the application had no room for it.
    Unanswered,
    TimedOut,
}

/// Connects to all endpoints concurrently. Succeeds if at least one connects, and returns the others as well.
pub(super) fn connect_all(
    endpoints: &[String],
    login: Option<&Login>,
    tls: Option<&Tls>,
) -> Result<(Vec<std::sync::Arc<Connection>>, Vec<Unanswered>), Error> {
    // A client with a certificate always presents it.
    let tls = tls.map(|tls| Tls {
        clients: tls.identity.is_some(),
        ..tls.clone()
    });
    let connect = |endpoint: &String| Connection::network(endpoint, login, tls.as_ref());
    let connected = super::map_concurrently(endpoints, connect);
    let mut connections = Vec::new();
    let (mut failed, mut unanswered) = (Vec::new(), Vec::new());
    for (endpoint, connection) in endpoints.iter().zip(connected) {
        match connection {
            Ok(connection) => connections.push(std::sync::Arc::new(connection)),
            Err(error) => {
                unanswered.push(Unanswered::new(endpoint, &error));
                failed.push(error);
            }
        }
    }
    match failed.len() {
        1.. if !connections.is_empty() => Ok((connections, unanswered)),
        1 => Err(failed.remove(0)),
        2.. => Err(Error::Several(failed)),
        _ => Ok((connections, unanswered)),
    }
}

impl Connection {
    pub(crate) fn local(entry: &RunningEntry) -> Result<Self, Error> {
        let endpoint = format!("unixsock-stream/{}", entry.socket.display());
        let start = Instant::now();
        loop {
            let opened = session::open(&SessionOptions {
                connect: std::slice::from_ref(&endpoint),
                ..SessionOptions::default()
            });
            match opened {
                Ok(session) => {
                    let opened = Self::from_session(session, endpoint, false)?;
                    return Ok(opened.into_private());
                }
                // The application holds the lock on its announcement, so it runs. A socket refuses at once
                // when more clients connect than it accepts at a time.
                Err(Error::Open(reason)) => {
                    tracing::debug!("{endpoint}: {reason}");
                    let waited = start.elapsed();
                    if waited >= RETRY_FOR {
                        let application = entry.about.name.clone();
                        return Err(Error::Timeout { application, waited });
                    }
                    std::thread::sleep(RETRY_PAUSE);
                }
                Err(other) => return Err(other),
            }
        }
    }

    fn from_session(session: Session, endpoint: String, shared: bool) -> Result<Self, Error> {
        Ok(Self {
            session: Some(session),
            endpoint,
            client: new_id()?,
            shared,
            is_private: false,
        })
    }

    fn into_private(mut self) -> Self {
        self.is_private = true;
        self
    }

    pub(super) fn network(endpoint: &str, login: Option<&Login>, tls: Option<&Tls>) -> Result<Self, Error> {
        let endpoint = endpoint.to_owned();
        let encrypted = endpoint.starts_with("tls/");
        let authority = tls.is_some_and(|tls| tls.authority.is_some());
        if login.is_some() && !(encrypted && authority) {
            return Err(Error::PlainPassword { endpoint });
        }
        if encrypted && !authority {
            let reason = "no certificate is trusted without an `authority` in `tls`".to_owned();
            return Err(Error::Connect { endpoint, reason });
        }
        login.map_or(Ok(()), Login::check)?;
        let opened = session::open(&SessionOptions {
            connect: std::slice::from_ref(&endpoint),
            login,
            tls,
            ..SessionOptions::default()
        });
        match opened {
            Ok(session) => Self::from_session(session, endpoint, false),
            Err(Error::Open(reason)) => Err(Error::Connect { endpoint, reason }),
            Err(other) => Err(other),
        }
    }

    /// Uses a session that another component closes.
    pub(crate) fn shared(session: Session, endpoint: &str) -> Result<Self, Error> {
        Self::from_session(session, endpoint.to_owned(), true)
    }

    /// The description of the application at a key.
    pub(crate) fn about(&self, key: &str) -> Result<About, Error> {
        let refused = |refused| Error::refused(&self.endpoint, refused);
        match self.query_one(key, None, super::REPLY_TIMEOUT)? {
            QueryOutcome::Reply(reply) => decode::about_at(key, &reply.message).map_err(refused),
            QueryOutcome::Refused(refusal) => Err(refused(Refused::Unreadable(refusal.error))),
            QueryOutcome::Unanswered | QueryOutcome::TimedOut => Err(Error::Timeout {
                application: self.endpoint.clone(),
                waited: super::REPLY_TIMEOUT,
            }),
        }
    }

    pub(super) fn is_private(&self) -> bool {
        self.is_private
    }

    pub(super) fn endpoint(&self) -> &str {
        &self.endpoint
    }

    pub(crate) fn session(&self) -> &Session {
        self.session.as_ref().expect("taken only when it is dropped")
    }

    /// Returns a query to be sent.
    fn request(
        &self,
        selector: &str,
        target: QueryTarget,
        payload: Option<Vec<u8>>,
        timeout: Duration,
    ) -> SessionGetBuilder<'_, 'static, DefaultHandler> {
        let request = self
            .session()
            .get(selector.to_owned())
            .target(target)
            .consolidation(ConsolidationMode::None)
            .congestion_control(CongestionControl::Block)
            .attachment(self.client.as_str())
            .timeout(timeout);
        // Requests with a payload take precedence over queries, and so do their replies.
        match payload {
            Some(payload) => request
                .payload(payload)
                .priority(Priority::RealTime)
                .express(true),
            None => request,
        }
    }

    /// Calls `on_reply` with the key and content of each reply as it arrives. Returns whether the query ended
    /// in time.
    pub(super) fn query(
        &self,
        selector: &str,
        payload: Option<Vec<u8>>,
        timeout: Duration,
        mut on_reply: impl FnMut(&str, Result<Vec<u8>, Refusal>),
    ) -> Result<bool, Error> {
        let (sender, replies) = mpsc::sync_channel(MAX_REPLIES);
        self.request(selector, QueryTarget::All, payload, timeout)
            .callback(move |reply| drop(sender.try_send(reply.into_result())))
            .wait()
            .map_err(|error| Error::Open(error.to_string()))?;
        let mut deadline = Instant::now() + timeout;
        for _ in 0..MAX_REPLIES {
            match replies.recv_timeout(deadline.saturating_duration_since(Instant::now())) {
                Ok(Ok(sample)) => {
                    let message = sample.payload().to_bytes().into_owned();
                    on_reply(sample.key_expr().as_str(), Ok(message));
                    deadline = deadline.min(Instant::now() + NEXT_REPLY_TIMEOUT);
                }
                // An error that is no refusal is a timeout.
                Ok(Err(refused)) => match decode::refusal(&refused.payload().to_bytes()) {
                    Ok(refusal) => on_reply("", Err(refusal)),
                    Err(_) => return Ok(false),
                },
                Err(mpsc::RecvTimeoutError::Disconnected) => return Ok(true),
                Err(mpsc::RecvTimeoutError::Timeout) => return Ok(false),
            }
        }
        Ok(false)
    }

    /// Sends a query that has one reply.
    pub(crate) fn query_one(
        &self,
        selector: &str,
        payload: Option<Vec<u8>>,
        timeout: Duration,
    ) -> Result<QueryOutcome, Error> {
        let (sender, replies) = mpsc::channel();
        let start = Instant::now();
        self.request(selector, QueryTarget::BestMatching, payload, timeout)
            .callback(move |reply| {
                let _ = sender.send(reply.into_result());
            })
            .wait()
            .map_err(|error| Error::Open(error.to_string()))?;
        // Zenoh itself reports a query that timed out.
        let reply = replies.recv_timeout(timeout + Duration::from_secs(1));
        let waited = start.elapsed();
        Ok(match reply {
            Ok(Ok(sample)) => QueryOutcome::Reply(Reply {
                message: sample.payload().to_bytes().into_owned(),
                attachment: sample
                    .attachment()
                    .map(|attachment| attachment.to_bytes().into_owned()),
            }),
            Ok(Err(refused)) => match decode::refusal(&refused.payload().to_bytes()) {
                Ok(refusal) => QueryOutcome::Refused(refusal),
                Err(_) if waited < timeout => QueryOutcome::Unanswered,
                Err(_) => QueryOutcome::TimedOut,
            },
            Err(_) if waited < timeout => QueryOutcome::Unanswered,
            Err(_) => QueryOutcome::TimedOut,
        })
    }
}

impl Drop for Connection {
    fn drop(&mut self) {
        if let Some(session) = self.session.take()
            && !self.shared
        {
            session::close(session);
        }
    }
}
