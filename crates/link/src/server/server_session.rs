//! One entrance: a session with its subscribers and publishers. The private socket and the network are two
//! doors without a connection between them. So an origin cannot be forged, and no client reaches one
//! application through another.

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
        let asks = Arc::clone(inbox);
        session
            .declare_queryable(keys.all())
            .complete(true)
            .callback(move |query| asks.push_query(origin, query))
            .background()
            .wait()
            .map_err(failed)?;
        for tokens in keys.tokens() {
            let (wants, below) = (Arc::clone(inbox), keys.clone());
            session
                .liveliness()
                .declare_subscriber(tokens)
                .history(true)
                .callback(move |token| {
                    let there = token.kind() == SampleKind::Put;
                    wants.update_demand(origin, &below, token.key_expr().as_str(), there);
                })
                .background()
                .wait()
                .map_err(failed)?;
        }
        let outlet = |what: &str| LazyPublisher::open(&session, keys.of(what), inbox);
        let events = [
            outlet(keys::events(RecordKind::ALL[0]))?,
            outlet(keys::events(RecordKind::ALL[1]))?,
            outlet(keys::events(RecordKind::ALL[2]))?,
        ];
        let hierarchy = outlet(keys::HIERARCHY)?;
        // Last: a client that sees the token finds everything else.
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
        let listened = Arc::new(AtomicBool::new(false));
        let (known, waiting) = (Arc::clone(&listened), Arc::clone(inbox));
        publisher
            .matching_listener()
            .callback(move |status| {
                known.store(status.matching(), Ordering::Release);
                waiting.wake();
            })
            .background()
            .wait()
            .map_err(failed)?;
        Ok(Self {
            publisher,
            has_subscribers: listened,
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

/// The access rules of a door, for every peer: it may query and subscribe, and the applications that
/// variables are imported from may send values. No peer can publish or answer under this application's keys,
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
        let of_peers = |what: &str| {
            let key = |peer: &String| format!("{}/{what}", keys::of_name(peer));
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
