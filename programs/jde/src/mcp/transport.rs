//! The stream of messages below the protocol's library, which would close it at the first line that it does not
//! understand. Here such a line gets an error, and the next line is read.

use std::collections::HashSet;
use std::convert::Infallible;
use std::io;
use std::sync::Arc;
use std::thread::Builder;

use parking_lot::Mutex;
use rmcp::RoleServer;
use rmcp::model::{ErrorCode, JsonRpcMessage, RequestId};
use rmcp::service::{RxJsonRpcMessage, TxJsonRpcMessage};
use rmcp::transport::Transport;
use serde_json::{Map, Value, json};
use tokio::sync::mpsc::{Receiver, channel};

use super::end::End;
use super::lines::{Line, Lines};
use super::output::Output;

/// The most bytes of a message: a call names things, and carries no data.
pub(super) const MAX_MESSAGE: usize = 1 << 20;
/// Lines that wait to be read.
const MAX_WAITING: usize = 64;
/// The key of the protocol's version in a request that needs no `initialize` before it.
const INLINE_VERSION: &str = "io.modelcontextprotocol/protocolVersion";

/// The lines of a client, and what answers it. A clone is the same stream.
#[derive(Clone)]
pub(super) struct LineTransport {
    lines: Arc<tokio::sync::Mutex<Receiver<Line>>>,
    output: Output,
    state: Arc<Mutex<State>>,
}

/// What the messages so far have begun.
#[derive(Default)]
struct State {
    /// Whether a session has begun.
    has_begun: bool,
    /// Requests without an answer yet.
    open: HashSet<RequestId>,
}

/// What to do with a line.
enum Reception {
    Pass(Box<RxJsonRpcMessage<RoleServer>>),
    Ignore,
    /// An error, and the request that it answers if that is known.
    Refuse(ErrorCode, String, Value),
}

impl LineTransport {
    /// Begins to read standard input.
    ///
    /// # Errors
    /// The system refuses a thread.
    pub(super) fn start(output: Output, end: &End) -> io::Result<Self> {
        let (sender, lines) = channel(MAX_WAITING);
        let end = end.clone();
        Builder::new().name("mcp-input".to_owned()).spawn(move || {
            let mut input = Lines::new(io::stdin().lock(), MAX_MESSAGE);
            while let Ok(Some(line)) = input.next() {
                if sender.blocking_send(line).is_err() {
                    break;
                }
            }
            end.begin("the input ended");
        })?;
        Ok(Self {
            lines: Arc::new(tokio::sync::Mutex::new(lines)),
            output,
            state: Arc::default(),
        })
    }

    /// Lets another session begin, after one that could not.
    pub(super) fn begin_again(&self) {
        *self.state.lock() = State::default();
    }
}

impl Transport<RoleServer> for LineTransport {
    type Error = Infallible;

    fn send(
        &mut self,
        message: TxJsonRpcMessage<RoleServer>,
    ) -> impl Future<Output = Result<(), Infallible>> + Send + 'static {
        let answered = match &message {
            JsonRpcMessage::Response(response) => Some(&response.id),
            JsonRpcMessage::Error(error) => error.id.as_ref(),
            JsonRpcMessage::Request(_) | JsonRpcMessage::Notification(_) => None,
        };
        if let Some(id) = answered {
            self.state.lock().open.remove(id);
        }
        match serde_json::to_string(&message) {
            Ok(json) => self.output.send(&json),
            Err(error) => tracing::error!("an answer is no JSON: {error}"),
        }
        std::future::ready(Ok(()))
    }

    async fn receive(&mut self) -> Option<RxJsonRpcMessage<RoleServer>> {
        let mut lines = self.lines.lock().await;
        loop {
            let line = lines.recv().await?;
            match self.state.lock().receive(line) {
                Reception::Pass(message) => return Some(*message),
                Reception::Ignore => {}
                Reception::Refuse(code, message, id) => {
                    let error = json!({"code": code.0, "message": message});
                    self.output
                        .send(&json!({"jsonrpc": "2.0", "id": id, "error": error}).to_string());
                }
            }
        }
    }

    async fn close(&mut self) -> Result<(), Infallible> {
        Ok(())
    }
}

impl State {
    fn receive(&mut self, line: Line) -> Reception {
        let refuse = |code, message: &str, id| Reception::Refuse(code, message.to_owned(), id);
        let text = match line {
            Line::Text(text) => text,
            Line::TooLong => {
                let message = format!("a message has at most {MAX_MESSAGE} bytes");
                return Reception::Refuse(ErrorCode::INVALID_REQUEST, message, Value::Null);
            }
            Line::NotText => return refuse(ErrorCode::PARSE_ERROR, "the line is not UTF-8", Value::Null),
        };
        if text.trim().is_empty() {
            return Reception::Ignore;
        }
        let value: Value = match serde_json::from_str(&text) {
            Ok(value) => value,
            Err(error) => {
                let message = format!("the line is not JSON: {error}");
                return Reception::Refuse(ErrorCode::PARSE_ERROR, message, Value::Null);
            }
        };
        let Value::Object(object) = &value else {
            return refuse(
                ErrorCode::INVALID_REQUEST,
                "a message is a JSON object, and each has a line of its own",
                Value::Null,
            );
        };
        let readable_id = |id: &&Value| id.is_string() || id.is_i64();
        let id = object.get("id").filter(readable_id).cloned().unwrap_or_default();
        if let Some(reason) = self.check(object) {
            return refuse(ErrorCode::INVALID_REQUEST, reason, id);
        }
        let is_answer = object.contains_key("result") || object.contains_key("error");
        match serde_json::from_value::<RxJsonRpcMessage<RoleServer>>(value) {
            Ok(message) => self.accept(message),
            // An answer to a question that nobody asked has none itself.
            Err(_) if is_answer => Reception::Ignore,
            Err(error) => {
                let message = format!("the message is none of the protocol: {error}");
                Reception::Refuse(ErrorCode::INVALID_REQUEST, message, id)
            }
        }
    }

    /// Returns why a request cannot be answered now, if it is one.
    fn check(&self, object: &Map<String, Value>) -> Option<&'static str> {
        let method = object.get("method")?.as_str()?;
        object.get("id")?;
        let states_version = || {
            let meta = object.get("params")?.get("_meta")?;
            meta.get(INLINE_VERSION)
        };
        match method {
            "initialize" if self.has_begun => Some("the session is initialized already"),
            "initialize" | "ping" => None,
            _ if self.has_begun || states_version().is_some() => None,
            _ => Some("the first request of a session is `initialize`"),
        }
    }

    fn accept(&mut self, message: RxJsonRpcMessage<RoleServer>) -> Reception {
        use rmcp::model::{ClientNotification, ClientRequest};
        match &message {
            JsonRpcMessage::Request(request) => {
                if !self.open.insert(request.id.clone()) {
                    let message = format!("a request with the id {} has no answer yet", request.id);
                    return Reception::Refuse(ErrorCode::INVALID_REQUEST, message, Value::Null);
                }
                // What may precede a session begins none; everything else that `check` lets pass does.
                self.has_begun |= !matches!(
                    request.request,
                    ClientRequest::PingRequest(_) | ClientRequest::DiscoverRequest(_)
                );
            }
            // Before a session begins, the library would take it for a failure.
            _ if !self.has_begun => return Reception::Ignore,
            JsonRpcMessage::Notification(notification) => {
                if let ClientNotification::CancelledNotification(cancelled) = &notification.notification
                    && let Some(id) = &cancelled.params.request_id
                {
                    self.open.remove(id);
                }
            }
            JsonRpcMessage::Response(_) | JsonRpcMessage::Error(_) => {}
        }
        Reception::Pass(Box::new(message))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn receive(state: &mut State, line: &str) -> String {
        match state.receive(Line::Text(line.to_owned())) {
            Reception::Pass(_) => "pass".to_owned(),
            Reception::Ignore => "ignore".to_owned(),
            Reception::Refuse(code, message, id) => format!("{} {id} {message}", code.0),
        }
    }

    const INITIALIZE: &str = r#"{"jsonrpc":"2.0","id":1,"method":"initialize","params":{"protocolVersion":"2025-11-25","capabilities":{},"clientInfo":{"name":"t","version":"1"}}}"#;

    #[test]
    fn what_is_no_message_gets_an_error_with_the_id_if_it_has_one() {
        let mut state = State::default();
        let mut receive = |line: &str| receive(&mut state, line);
        assert!(receive("{").starts_with("-32700 null"));
        assert!(receive("[]").starts_with("-32600 null"));
        assert!(receive("7").starts_with("-32600 null"));
        assert!(receive(r#"{"id": 7}"#).starts_with("-32600 7"));
        assert!(receive(r#"{"jsonrpc": "2.0", "id": {}, "method": 3}"#).starts_with("-32600 null"));
        assert!(receive(&"[".repeat(10_000)).starts_with("-32700 null"));
        assert_eq!(receive("  "), "ignore");
    }

    #[test]
    fn a_session_begins_with_initialize_once() {
        let mut state = State::default();
        let list = r#"{"jsonrpc":"2.0","id":2,"method":"tools/list"}"#;
        let refused = receive(&mut state, list);
        assert!(refused.starts_with("-32600 2 the first request"), "{refused}");
        let early = r#"{"jsonrpc":"2.0","method":"notifications/initialized"}"#;
        assert_eq!(receive(&mut state, early), "ignore");
        assert_eq!(
            receive(&mut state, r#"{"jsonrpc":"2.0","id":1,"result":{}}"#),
            "ignore"
        );
        assert_eq!(receive(&mut state, INITIALIZE), "pass");
        assert_eq!(receive(&mut state, list), "pass");
        let again = receive(&mut state, INITIALIZE);
        assert!(again.starts_with("-32600 1 the session"), "{again}");
    }

    #[test]
    fn an_id_is_used_by_one_request_at_a_time() {
        let mut state = State::default();
        receive(&mut state, INITIALIZE);
        let ping = r#"{"jsonrpc":"2.0","id":"a","method":"ping"}"#;
        assert_eq!(receive(&mut state, ping), "pass");
        assert!(receive(&mut state, ping).starts_with("-32600 null a request with the id a"));
        let cancel = r#"{"jsonrpc":"2.0","method":"notifications/cancelled","params":{"requestId":"a"}}"#;
        assert_eq!(receive(&mut state, cancel), "pass");
        assert_eq!(receive(&mut state, ping), "pass");
    }
}
