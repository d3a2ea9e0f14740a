//! One session of an application, with its subscribers and publishers. The private socket and the network
//! have separate sessions without a connection between them, so an origin cannot be forged, and no client
//! reaches one application through another.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use jde_records::RecordKind;
use serde_json::{Value, json};
use zenoh::bytes::ZBytes;
use zenoh::liveliness::LivelinessToken;
use zenoh::pubsub::Publisher;
use zenoh::qos::CongestionControl;
use zenoh::sample::SampleKind;
use zenoh::{Session, Wait};

use super::inbox::{Inbox, Origin};
use crate::keys::{self, Keys};
use crate::{Error, session};

/// A session and its declarations.
pub(super) struct ServerSession {
    pub(super) origin: Origin,
    pub(super) session: Session,
    pub(super) hierarchy: LazyPublisher,
    events: [LazyPublisher; RecordKind::ALL.len()],
    alive: Option<LivelinessToken>,
}

/// A publication that is sent only while it has subscribers.
pub(super) struct LazyPublisher {
    publisher: Publisher<'static>,
    has_subscribers: Arc<AtomicBool>,
}

impl ServerSession {
    pub(super) fn open(
        origin: Origin,
        session: Session,
        keys: &Keys,
        inbox: &Arc<Inbox>,
    ) -> Result<Self, Error> {
        let failed = |error: zenoh::Error| Error::Open(error.to_string());
        let query_inbox = Arc::clone(inbox);
        session
            .declare_queryable(keys.all())
            .complete(true)
            .callback(move |query| query_inbox.push_query(origin, query))
            .background()
            .wait()
            .map_err(failed)?;
        for tokens in keys.tokens() {
            let (token_inbox, token_keys) = (Arc::clone(inbox), keys.clone());
            session
                .liveliness()
                .declare_subscriber(tokens)
                .history(true)
                .callback(move |token| {
                    let is_present = token.kind() == SampleKind::Put;
                    token_inbox.update_demand(origin, &token_keys, token.key_expr().as_str(), is_present);
                })
                .background()
                .wait()
                .map_err(failed)?;
        }
        let publisher = |path: &str| LazyPublisher::open(&session, keys.of(path), inbox);
        let events = [
            publisher(keys::events(RecordKind::ALL[0]))?,
            publisher(keys::events(RecordKind::ALL[1]))?,
            publisher(keys::events(RecordKind::ALL[2]))?,
        ];
        let hierarchy = publisher(keys::HIERARCHY)?;
        // Declared last: a client that sees the token finds everything else.
        let alive = session
            .liveliness()
            .declare_token(keys.of(keys::ALIVE))
            .wait()
            .map_err(failed)?;
        Ok(Self {
            origin,
            session,
            hierarchy,
            events,
            alive: Some(alive),
        })
    }

    pub(super) fn events(&self, kind: RecordKind) -> &LazyPublisher {
        &self.events[kind as usize]
    }

    /// Announces the end of the application, and closes the session.
    pub(super) fn close(mut self) {
        if let Some(alive) = self.alive.take() {
            let _ = alive.undeclare().wait();
        }
        session::close(self.session);
    }
}

impl LazyPublisher {
    fn open(session: &Session, key: String, inbox: &Arc<Inbox>) -> Result<Self, Error> {
        let failed = |error: zenoh::Error| Error::Open(error.to_string());
        let publisher = session
            .declare_publisher(key)
            .congestion_control(CongestionControl::Drop)
            .wait()
            .map_err(failed)?;
        let has_subscribers = Arc::new(AtomicBool::new(false));
        let (flag, worker) = (Arc::clone(&has_subscribers), Arc::clone(inbox));
        publisher
            .matching_listener()
            .callback(move |status| {
                flag.store(status.matching(), Ordering::Release);
                worker.wake();
            })
            .background()
            .wait()
            .map_err(failed)?;
        Ok(Self {
            publisher,
            has_subscribers,
        })
    }

    /// Whether there are subscribers.
    pub(super) fn has_subscribers(&self) -> bool {
        self.has_subscribers.load(Ordering::Acquire)
    }

    pub(super) fn put(&self, message: ZBytes, attachment: Option<Vec<u8>>) {
        let put = self.publisher.put(message);
        let sent = match attachment {
            Some(attachment) => put.attachment(attachment).wait(),
            None => put.wait(),
        };
        if let Err(error) = sent {
            tracing::debug!("{} was not sent: {error}", self.publisher.key_expr());
        }
    }
}

/// The access rules of a session, for every peer: it may query and subscribe, and the applications from which
/// variables are imported may send values. No peer can publish or answer under this application's keys,
/// or reach other clients through it.
pub(super) fn access_rules(keys: &Keys, peers: &[String]) -> Value {
    let rule = |id: &str, flow: &str, messages: Value, keys: Vec<String>| {
        json!({
            "id": id, "permission": "allow", "flows": [flow], "messages": messages, "key_exprs": keys,
        })
    };
    let mut rules = vec![
        rule(
            "ask",
            "ingress",
            json!([
                "query",
                "declare_subscriber",
                "liveliness_query",
                "declare_liveliness_subscriber"
            ]),
            vec!["jde/**".to_owned()],
        ),
        rule(
            "want",
            "ingress",
            json!(["liveliness_token"]),
            keys.tokens().to_vec(),
        ),
        rule(
            "speak",
            "egress",
            json!([
                "put",
                "delete",
                "query",
                "reply",
                "declare_subscriber",
                "declare_queryable",
                "liveliness_token",
                "liveliness_query",
                "declare_liveliness_subscriber"
            ]),
            vec!["jde/**".to_owned()],
        ),
    ];
    if !peers.is_empty() {
        let of_peers = |path: &str| {
            let key = |peer: &String| format!("{}/{path}", keys::of_name(peer));
            peers.iter().map(key).collect::<Vec<_>>()
        };
        rules.push(rule(
            "peers",
            "ingress",
            json!(["put", "reply", "declare_queryable", "liveliness_token"]),
            of_peers("**"),
        ));
    }
    let ids: Vec<_> = rules.iter().map(|rule| rule["id"].clone()).collect();
    json!({
        "enabled": true,
        "default_permission": "deny",
        "rules": rules,
        "subjects": [{ "id": "anybody" }],
        "policies": [{ "rules": ids, "subjects": ["anybody"] }],
    })
}
