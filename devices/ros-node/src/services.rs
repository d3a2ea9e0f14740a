//! Services, as rmw_zenoh has them: a request is a query, and its response is the reply.

use std::borrow::Cow;
use std::sync::Arc;
use std::time::{Duration, Instant};

use parking_lot::Mutex;
use zenoh::bytes::ZBytes;
use zenoh::query::{ConsolidationMode, Query, QueryTarget, Queryable};
use zenoh::{Session, Wait};

use crate::attachment::{Gid, attachment_now, parse};
use crate::keys::Service;
use crate::shared::Shared;

/// A service that the node calls.
#[derive(Clone, Debug)]
pub struct Client {
    /// The service.
    pub service: Service,
    /// How long it waits for a response.
    pub timeout: Duration,
}

/// A request to a service of this node.
#[derive(Debug)]
pub struct Request {
    /// The number of the service.
    pub service: usize,
    /// When it arrived.
    pub received_at: Instant,
    query: Query,
}

/// The outcome of a request of this node.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Response {
    /// The number of the request.
    pub sequence: i64,
    /// The message, or the reason why there is none.
    pub outcome: Result<Vec<u8>, String>,
}

impl Request {
    fn new(service: usize, query: Query) -> Self {
        Self {
            service,
            received_at: Instant::now(),
            query,
        }
    }

    /// Its message.
    #[must_use]
    pub fn message(&self) -> Cow<'_, [u8]> {
        self.query.payload().map_or(Cow::Borrowed(&[]), ZBytes::to_bytes)
    }

    /// Sends the response, or the reason why there is none.
    pub(crate) fn reply(self, response: Result<Vec<u8>, String>) -> zenoh::Result<()> {
        let response = match response {
            Ok(response) => response,
            Err(reason) => return self.query.reply_err(reason).wait(),
        };
        let attachment = self.query.attachment().map(ZBytes::to_bytes);
        let (sequence, gid) = attachment.as_deref().and_then(parse).unwrap_or_default();
        self.query
            .reply(self.query.key_expr(), response)
            .attachment(attachment_now(sequence, gid))
            .wait()
    }
}

/// Offers a service of that key. Requests without a message or an attachment are ignored.
pub(crate) fn serve(
    session: &Session,
    key: &str,
    shared: &Arc<Shared>,
    service: usize,
) -> zenoh::Result<Queryable<()>> {
    let shared = Arc::clone(shared);
    session
        .declare_queryable(key)
        .complete(true)
        .callback(move |query| {
            let attachment = query.attachment().map(ZBytes::to_bytes);
            if query.payload().is_some()
                && attachment.as_deref().and_then(parse).is_some()
                && let Some((request, waiting)) = shared.request(Request::new(service, query))
            {
                let _ = request.reply(Err(format!("{waiting} requests wait already")));
            }
        })
        .wait()
}

/// What reports the outcome of a call, at the latest when Zenoh drops it.
struct Pending {
    shared: Arc<Shared>,
    client: usize,
    sequence: i64,
    error: Mutex<Option<String>>,
}

impl Drop for Pending {
    fn drop(&mut self) {
        if let Some(error) = self.error.lock().take() {
            self.shared.respond(self.client, self.sequence, Err(error));
        }
    }
}

/// Sends a request. Its outcome is reported later: the first response, or the reason why there is none.
pub(crate) fn call(
    session: &Session,
    key: &str,
    shared: &Arc<Shared>,
    (number, client): (usize, &Client),
    (sequence, message): (i64, Vec<u8>),
    gid: Gid,
) {
    let pending = Pending {
        shared: Arc::clone(shared),
        client: number,
        sequence,
        error: Mutex::new(Some(format!("no node answers `{}`", client.service.name))),
    };
    // If it cannot be sent, the callback is dropped.
    let _ = session
        .get(key)
        .target(QueryTarget::AllComplete)
        .consolidation(ConsolidationMode::None)
        .timeout(client.timeout)
        .payload(message)
        .attachment(attachment_now(sequence, gid))
        .callback(move |reply| {
            let mut error = pending.error.lock();
            match reply.into_result() {
                Ok(sample) => {
                    if error.take().is_some() {
                        let message = sample.payload().to_bytes().into_owned();
                        pending.shared.respond(number, sequence, Ok(message));
                    }
                }
                Err(refusal) => {
                    if let (Some(error), Ok(text)) = (&mut *error, refusal.payload().try_to_string()) {
                        *error = format!("{error}: {text}");
                    }
                }
            }
        })
        .wait();
}
