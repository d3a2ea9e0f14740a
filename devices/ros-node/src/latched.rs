//! Latched topics (transient local), with the keys of Zenoh's advanced publishers and subscribers, which
//! rmw_zenoh uses: a publication answers queries for its newest messages, and announces that it does; a
//! subscription queries each such publication once. A subscriber of rmw_zenoh queries twice, and recognises a repeated
//! message by the time of Zenoh that it has.
//!
//! The extension crate of Zenoh is not used: its interface is unstable, and would make that of Zenoh unstable
//! for the whole workspace.

use std::collections::VecDeque;
use std::sync::Arc;

use parking_lot::Mutex;
use zenoh::bytes::ZBytes;
use zenoh::liveliness::LivelinessToken;
use zenoh::pubsub::Subscriber;
use zenoh::query::{ConsolidationMode, Queryable, ReplyKeyExpr};
use zenoh::sample::SampleKind;
use zenoh::time::Timestamp;
use zenoh::{Session, Wait};

use crate::shared::Shared;

/// The parameter of a query that states the greatest number of messages.
const MAX: &str = "_max";

/// The newest messages of a publication.
#[derive(Debug)]
pub(crate) struct Cache {
    newest: Arc<Mutex<VecDeque<Kept>>>,
    depth: usize,
    session: Session,
    _queryable: Queryable<()>,
    _token: LivelinessToken,
}

/// A message, its attachment, and when it was sent.
type Kept = (ZBytes, ZBytes, Timestamp);

impl Cache {
    /// Answers queries for the messages of a key; `number` is unique within the session.
    pub(crate) fn declare(session: &Session, key: &str, number: usize, depth: usize) -> zenoh::Result<Self> {
        let newest: Arc<Mutex<VecDeque<Kept>>> = Arc::default();
        let own_key = format!("{key}/@adv/pub/{}/{number}/_", session.zid());
        let (messages, message_key) = (Arc::clone(&newest), key.to_owned());
        let queryable = session
            .declare_queryable(&own_key)
            .callback(move |query| {
                let max = query.parameters().get(MAX).and_then(|max| max.parse().ok());
                let messages = messages.lock().clone();
                let skipped = messages.len().saturating_sub(max.unwrap_or(usize::MAX));
                for (message, attachment, time) in messages.into_iter().skip(skipped) {
                    let reply = query.reply(&message_key, message).attachment(attachment);
                    // One that cannot be sent is lost, as on an unreliable network.
                    let _ = reply.timestamp(time).wait();
                }
            })
            .wait()?;
        Ok(Self {
            newest,
            depth,
            session: session.clone(),
            _queryable: queryable,
            _token: session.liveliness().declare_token(own_key).wait()?,
        })
    }

    /// Keeps a message and its attachment. Returns its time.
    pub(crate) fn keep(&self, message: ZBytes, attachment: ZBytes) -> Timestamp {
        let time = self.session.new_timestamp();
        let mut newest = self.newest.lock();
        if newest.len() >= self.depth {
            newest.pop_front();
        }
        newest.push_back((message, attachment, time));
        time
    }
}

/// Reports every publication of a key that answers such queries.
pub(crate) fn find_caches(
    session: &Session,
    key: &str,
    shared: &Arc<Shared>,
    subscription: usize,
) -> zenoh::Result<Subscriber<()>> {
    let shared = Arc::clone(shared);
    session
        .liveliness()
        .declare_subscriber(format!("{key}/@adv/pub/**"))
        .history(true)
        .callback(move |sample| {
            if sample.kind() == SampleKind::Put {
                shared.found_cache(subscription, sample.key_expr().to_string());
            }
        })
        .wait()
}

/// Queries the newest messages of a publication. Their arrival is reported later.
pub(crate) fn query(
    session: &Session,
    cache: &str,
    shared: &Arc<Shared>,
    subscription: usize,
    depth: usize,
) -> zenoh::Result<()> {
    let shared = Arc::clone(shared);
    session
        .get(format!("{cache}?{MAX}={depth}"))
        .consolidation(ConsolidationMode::None)
        .accept_replies(ReplyKeyExpr::Any)
        .callback(move |reply| {
            if let Ok(sample) = reply.into_result() {
                shared.arrive(subscription, &sample, true);
            }
        })
        .wait()
}
