//! The end of a server: it must not outlive its client. Whatever ends it begins the same orderly end, and a deadline
//! ends the process where that takes too long, as when nobody reads its output.

use std::io;
use std::os::fd::{AsFd, BorrowedFd, OwnedFd};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::Builder;
use std::time::Duration;

use jde_terminal as terminal;
use jde_terminal::interrupt::SignalListener;
use rustix::event::{PollFd, PollFlags, poll};
use rustix::process::{PidfdFlags, getppid, pidfd_open};
use signal_hook::low_level;
use tokio::sync::Notify;

/// The longest time from the cause to the end of the process: the promise is 2 s.
const END_DEADLINE: Duration = Duration::from_millis(1900);
/// The state of a stream whose other end is closed, or that is none.
const CLOSED_FLAGS: PollFlags = PollFlags::HUP
    .union(PollFlags::RDHUP)
    .union(PollFlags::ERR)
    .union(PollFlags::NVAL);

/// Whether the end has begun. A clone refers to the same.
#[derive(Clone)]
pub(super) struct End {
    inner: Arc<EndInner>,
}

struct EndInner {
    has_begun: AtomicBool,
    begun: Notify,
    /// Listens until the process ends; a second signal ends it at once.
    signals: parking_lot::Mutex<Option<SignalListener>>,
}

impl End {
    /// Watches standard input, the stream of the output, the process that started this one, and signals.
    ///
    /// # Errors
    /// The system refuses a thread.
    pub(super) fn watch(output: OwnedFd) -> io::Result<Self> {
        let end = Self {
            inner: Arc::new(EndInner {
                has_begun: AtomicBool::new(false),
                begun: Notify::new(),
                signals: parking_lot::Mutex::new(None),
            }),
        };
        let of_signals = end.clone();
        *end.inner.signals.lock() = Some(SignalListener::on_first(move || of_signals.begin("a signal"))?);
        let of_streams = end.clone();
        Builder::new()
            .name("mcp-end".to_owned())
            .spawn(move || of_streams.begin(wait_for_end(&output)))?;
        Ok(end)
    }

    /// Begins the end, once.
    pub(super) fn begin(&self, cause: &str) {
        if self.inner.has_begun.swap(true, Ordering::SeqCst) {
            return;
        }
        tracing::info!("the server ends: {cause}");
        terminal::finish_soon();
        let deadline = Builder::new().name("mcp-deadline".to_owned()).spawn(|| {
            std::thread::sleep(END_DEADLINE);
            low_level::exit(0);
        });
        if deadline.is_err() {
            low_level::exit(0);
        }
        self.inner.begun.notify_one();
    }

    /// Waits until the end has begun. For one waiter.
    pub(super) async fn begun(&self) {
        self.inner.begun.notified().await;
    }
}

/// Waits until the client is gone, and returns what shows it.
fn wait_for_end(output: &OwnedFd) -> &'static str {
    let parent = parent();
    loop {
        let input = rustix::stdio::stdin();
        let mut watched = vec![
            PollFd::from_borrowed_fd(input, PollFlags::RDHUP),
            PollFd::from_borrowed_fd(output.as_fd(), PollFlags::empty()),
        ];
        watched.extend(parent.as_ref().map(|parent| of_process(parent.as_fd())));
        if let Err(error) = poll(&mut watched, None) {
            match error {
                rustix::io::Errno::INTR => continue,
                _ => return "its streams cannot be watched",
            }
        }
        if watched[0].revents().intersects(CLOSED_FLAGS) {
            return "the input ended";
        }
        if watched[1].revents().intersects(CLOSED_FLAGS) {
            return "nobody reads the output";
        }
        if watched.get(2).is_some_and(|parent| !parent.revents().is_empty()) {
            return "the process that started it is gone";
        }
    }
}

/// Readable when the process has exited.
fn of_process(process: BorrowedFd<'_>) -> PollFd<'_> {
    PollFd::from_borrowed_fd(process, PollFlags::IN)
}

/// The process that started this one, if it can be watched.
fn parent() -> Option<OwnedFd> {
    pidfd_open(getppid()?, PidfdFlags::empty()).ok()
}
