//! One call of a tool: on a thread of its own, because the link and files make it wait, within a time, and until the
//! client cancels it.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::Builder;
use std::time::Duration;

use rmcp::model::{CallToolResult, JsonObject};
use tokio::sync::oneshot;

use super::answer::{reason, refusal};
use super::session::{MAX_CALLS, Running, Session};
use super::tools::{Call, Right, Tool};

/// The longest time of a call that simulates nothing: a long recording takes that long to be read.
const CALL_LIMIT: Duration = Duration::from_secs(60);

/// Sets a flag when it is dropped: when nobody waits for the call any more.
struct AbortGuard(Arc<AtomicBool>);

impl Drop for AbortGuard {
    fn drop(&mut self) {
        self.0.store(true, Ordering::Relaxed);
    }
}

/// Calls a tool if this server permits it, and waits for the result. `cancelled` ends when the client cancels the call.
pub(super) async fn run(
    session: &Arc<Session>,
    tool: &'static Tool,
    arguments: JsonObject,
    cancelled: impl Future<Output = ()>,
) -> CallToolResult {
    if !session.permits(tool.right) {
        return refusal(&format!(
            "this server permits no `{}`: it only inspects",
            tool.name
        ));
    }
    let Some(running) = Session::begin_call(session, tool.right) else {
        return refusal(&format!(
            "{MAX_CALLS} calls are under way, and no more are accepted"
        ));
    };
    let limit = match tool.right {
        Right::Simulate => session.limit,
        Right::Inspect | Right::Stop | Right::Operate => CALL_LIMIT,
    };
    let guard = AbortGuard(Arc::clone(&running.abort));
    let (sender, answer) = oneshot::channel();
    let of_call = Arc::clone(session);
    let started = Builder::new()
        .name("mcp-call".to_owned())
        .stack_size(STACK_BYTES)
        .spawn(move || {
            let result = perform(&of_call, tool, arguments, &running);
            drop(running);
            // The receiver is gone if the client has cancelled.
            let _ = sender.send(result);
        });
    if let Err(error) = started {
        return refusal(&format!("the system refuses a thread: {error}"));
    }
    let result = tokio::select! {
        result = answer => result.unwrap_or_else(|_| refusal("the call ended without an answer")),
        () = cancelled => refusal("the client has cancelled the call"),
        () = tokio::time::sleep(limit) => {
            refusal(&format!("the call took longer than {} s", limit.as_secs()))
        }
    };
    drop(guard);
    result
}

/// The stack of a call, bytes: a picture is a value of a megabyte, of which there are a few copies.
const STACK_BYTES: usize = 16 << 20;

fn perform(session: &Session, tool: &Tool, arguments: JsonObject, running: &Running) -> CallToolResult {
    let call = Call {
        session,
        abort: &running.abort,
    };
    let result = catch_unwind(AssertUnwindSafe(|| (tool.call)(&call, arguments)));
    match result {
        Ok(Ok(answer)) => answer.into_result(),
        Ok(Err(failure)) => refusal(&reason(&failure)),
        // The panic hook has printed it.
        Err(_) => refusal("the call failed: this is a fault of jde, which its log shows"),
    }
}
