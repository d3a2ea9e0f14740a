//! The messages to the client. A thread of its own writes them, so that a client that does not read delays no call, and
//! a server whose client reads nothing of many answers ends.

use std::io::{self, Write};
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::thread::Builder;
use std::time::Duration;

use jde_terminal::Printer;
use jde_terminal::escape::escape_json;
use parking_lot::Mutex;

use super::end::End;

/// The most bytes that wait for the client. Beyond that it is none.
const MAX_PENDING: usize = 64 << 20;

/// The stream of messages; a clone is the same stream.
#[derive(Clone)]
pub(super) struct Output {
    inner: Arc<OutputInner>,
}

struct OutputInner {
    /// `None` when nothing more is written.
    sender: Mutex<Option<Sender<String>>>,
    pending: Arc<AtomicUsize>,
    /// Disconnected when the thread has ended.
    written: Mutex<Receiver<()>>,
    end: End,
}

impl Output {
    /// Starts the thread.
    ///
    /// # Errors
    /// The system refuses it.
    pub(super) fn start(mut printer: Printer, end: &End) -> io::Result<Self> {
        let (sender, lines) = channel::<String>();
        let (running, written) = channel::<()>();
        let pending = Arc::new(AtomicUsize::new(0));
        let (of_thread, of_end) = (Arc::clone(&pending), end.clone());
        Builder::new().name("mcp-output".to_owned()).spawn(move || {
            let _running = running;
            for line in lines {
                let result = printer.write_all(line.as_bytes()).and_then(|()| printer.flush());
                of_thread.fetch_sub(line.len(), Ordering::Relaxed);
                if let Err(error) = result {
                    tracing::debug!("a message was not written: {error}");
                    of_end.begin("the output cannot be written");
                    return;
                }
            }
            // The end of the process waits for it, and no longer than its patience.
            let _ = printer.drain();
        })?;
        Ok(Self {
            inner: Arc::new(OutputInner {
                sender: Mutex::new(Some(sender)),
                pending,
                written: Mutex::new(written),
                end: end.clone(),
            }),
        })
    }

    /// Sends a message: JSON in one line.
    pub(super) fn send(&self, json: &str) {
        let line = escape_json(json) + "\n";
        let length = line.len();
        let before = self.inner.pending.fetch_add(length, Ordering::Relaxed);
        if before + length > MAX_PENDING {
            self.inner.end.begin("the client does not read");
            return;
        }
        if let Some(sender) = &*self.inner.sender.lock() {
            // The thread has ended if the client is gone.
            let _ = sender.send(line);
        }
    }

    /// Ends the stream, and waits until the client has read it, at most for `timeout`.
    pub(super) fn finish(&self, timeout: Duration) {
        drop(self.inner.sender.lock().take());
        let _ = self.inner.written.lock().recv_timeout(timeout);
    }
}
