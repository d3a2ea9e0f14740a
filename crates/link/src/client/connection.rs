//! A session of a client to one place. Each place has its own, so that nobody there is heard as somebody elsewhere.

use std::sync::mpsc;
use std::time::{Duration, Instant};

use zenoh::qos::CongestionControl;
use zenoh::query::{ConsolidationMode, QueryTarget};
use zenoh::{Session, Wait};

use crate::Error;
use crate::folder::Entry;
use crate::message::{About, Refusal};
use crate::session::{self, Login, Opening, Tls};

/// How long is knocked where nobody is let in, and how often.
const KNOCKING: Duration = Duration::from_secs(1);
const AGAIN: Duration = Duration::from_millis(20);

/// A session; closed when dropped, unless it is somebody else's.
pub(crate) struct Connection {
    session: Option<Session>,
    endpoint: String,
    shared: bool,
}

/// An answer with what is attached to it.
pub(crate) struct Answer {
    pub(crate) message: Vec<u8>,
    pub(crate) attachment: Option<Vec<u8>>,
}

/// How a question ended.
pub(crate) enum Answered {
    With(Answer),
    Refused(Refusal),
    /// It ended at once: nobody was there, or there was no room for it.
    NotAtAll,
    TooLate,
}

/// Connects to all endpoints at once; to one at least.
pub(super) fn all(
    endpoints: &[String],
    login: Option<&Login>,
    tls: Option<&Tls>,
) -> Result<Vec<std::sync::Arc<Connection>>, Error> {
    // Whoever has an identity shows it.
    let tls = tls.map(|tls| Tls {
        clients: tls.identity.is_some(),
        ..tls.clone()
    });
    let connected: Vec<_> = std::thread::scope(|scope| {
        let threads: Vec<_> = endpoints
            .iter()
            .map(|endpoint| {
                let tls = tls.as_ref();
                scope.spawn(move || Connection::network(endpoint, login, tls))
            })
            .collect();
        let joined = threads.into_iter().map(|thread| {
            thread
                .join()
                .unwrap_or_else(|panic| std::panic::resume_unwind(panic))
        });
        joined.collect()
    });
    let mut connections = Vec::new();
    let mut failed = None;
    for connection in connected {
        match connection {
            Ok(connection) => connections.push(std::sync::Arc::new(connection)),
            Err(error) => {
                tracing::warn!("{error}");
                failed.get_or_insert(error);
            }
        }
    }
    match failed {
        Some(error) if connections.is_empty() => Err(error),
        _ => Ok(connections),
    }
}

impl Connection {
    pub(crate) fn local(entry: &Entry) -> Result<Self, Error> {
        let endpoint = format!("unixsock-stream/{}", entry.socket.display());
        let start = Instant::now();
        loop {
            let opened = session::open(&Opening {
                connect: std::slice::from_ref(&endpoint),
                ..Opening::default()
            });
            match opened {
                Ok(session) => {
                    return Ok(Self {
                        session: Some(session),
                        endpoint,
                        shared: false,
                    });
                }
                // It holds the lock on its announcement, so it is there. Where more knock than are let in at a time, a socket
                // says so at once.
                Err(Error::Open(reason)) => {
                    tracing::debug!("{endpoint}: {reason}");
                    let waited = start.elapsed();
                    if waited >= KNOCKING {
                        let application = entry.about.name.clone();
                        return Err(Error::NoAnswer { application, waited });
                    }
                    std::thread::sleep(AGAIN);
                }
                Err(other) => return Err(other),
            }
        }
    }

    fn network(endpoint: &str, login: Option<&Login>, tls: Option<&Tls>) -> Result<Self, Error> {
        let endpoint = endpoint.to_owned();
        let opened = session::open(&Opening {
            connect: std::slice::from_ref(&endpoint),
            login,
            tls,
            ..Opening::default()
        });
        match opened {
            Ok(session) => Ok(Self {
                session: Some(session),
                endpoint,
                shared: false,
            }),
            Err(Error::Open(reason)) => Err(Error::Connect { endpoint, reason }),
            Err(other) => Err(other),
        }
    }

    /// Speaks over a session that somebody else closes.
    pub(crate) fn shared(session: Session, endpoint: &str) -> Self {
        Self {
            session: Some(session),
            endpoint: endpoint.to_owned(),
            shared: true,
        }
    }

    /// What an application is, by its key.
    pub(crate) fn about(&self, key: &str) -> Result<About, Error> {
        let garbled = |reason: String| Error::Garbled {
            application: self.endpoint.clone(),
            reason,
        };
        match self.ask_one(key, None, super::ANSWER)? {
            Answered::With(answer) => {
                serde_json::from_slice(&answer.message).map_err(|error| garbled(error.to_string()))
            }
            Answered::Refused(refusal) => Err(garbled(refusal.error)),
            Answered::NotAtAll | Answered::TooLate => Err(Error::NoAnswer {
                application: self.endpoint.clone(),
                waited: super::ANSWER,
            }),
        }
    }

    pub(super) fn endpoint(&self) -> &str {
        &self.endpoint
    }

    pub(crate) fn session(&self) -> &Session {
        self.session.as_ref().expect("taken only when it is dropped")
    }

    /// All answers to a question.
    pub(super) fn ask(&self, key: &str, timeout: Duration) -> Result<Vec<Vec<u8>>, Error> {
        let (tell, answers) = mpsc::channel();
        self.session()
            .get(key)
            .target(QueryTarget::All)
            .consolidation(ConsolidationMode::None)
            .congestion_control(CongestionControl::Block)
            .timeout(timeout)
            .callback(move |reply| {
                if let Ok(sample) = reply.into_result() {
                    let _ = tell.send(sample.payload().to_bytes().into_owned());
                }
            })
            .wait()
            .map_err(|error| Error::Open(error.to_string()))?;
        Ok(answers.iter().collect())
    }

    /// The answer to a question that has one.
    pub(crate) fn ask_one(
        &self,
        selector: &str,
        payload: Option<Vec<u8>>,
        timeout: Duration,
    ) -> Result<Answered, Error> {
        let (tell, answers) = mpsc::channel();
        let start = Instant::now();
        let mut get = self
            .session()
            .get(selector)
            .target(QueryTarget::BestMatching)
            .consolidation(ConsolidationMode::None)
            .congestion_control(CongestionControl::Block)
            .timeout(timeout);
        if let Some(payload) = payload {
            get = get.payload(payload);
        }
        get.callback(move |reply| {
            let _ = tell.send(reply.into_result());
        })
        .wait()
        .map_err(|error| Error::Open(error.to_string()))?;
        // Zenoh itself tells of a question that took too long.
        let answered = answers.recv_timeout(timeout + Duration::from_secs(1));
        let waited = start.elapsed();
        Ok(match answered {
            Ok(Ok(sample)) => Answered::With(Answer {
                message: sample.payload().to_bytes().into_owned(),
                attachment: sample
                    .attachment()
                    .map(|attachment| attachment.to_bytes().into_owned()),
            }),
            Ok(Err(refused)) => match serde_json::from_slice(&refused.payload().to_bytes()) {
                Ok(refusal) => Answered::Refused(refusal),
                Err(_) if waited < timeout => Answered::NotAtAll,
                Err(_) => Answered::TooLate,
            },
            Err(_) if waited < timeout => Answered::NotAtAll,
            Err(_) => Answered::TooLate,
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
