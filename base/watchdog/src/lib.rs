//! Ends a process that hangs, and reports the state of its threads. For tests and campaigns; no robot runs
//! it.
//!
//! It does not bound any behaviour: its limits are far above what any machine needs, so it distinguishes a
//! hang from a slow machine.

mod descendants;

use std::fs;
use std::io::{self, Write as _};
use std::panic::Location;
use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::thread::{self, JoinHandle};
use std::time::Duration;

/// How long a test may take before it counts as hanging: several times the slowest test on two busy cores.
pub const DEFAULT_LIMIT: Duration = Duration::from_secs(600);

/// How long the report may take. It may need a lock that a hanging thread holds.
const REPORT_TIMEOUT: Duration = Duration::from_secs(2);

/// Runs until it is dropped.
#[derive(Debug)]
pub struct Watchdog {
    /// Carries no message: the drop closes it.
    cancel: Option<Sender<()>>,
    thread: Option<JoinHandle<()>>,
}

/// When the drop returns, the thread has ended and has dropped the report.
impl Drop for Watchdog {
    fn drop(&mut self) {
        drop(self.cancel.take());
        if let Some(thread) = self.thread.take() {
            // A panic of the thread would add no information.
            drop(thread.join());
        }
    }
}

impl Watchdog {
    /// Starts a watchdog. If it is not dropped within `limit`, the process prints the state of each of its
    /// threads and the result of `report` on stderr, ends the processes that it has started and those that they have
    /// started, and exits with status 1.
    ///
    /// `report` runs on its own thread and may block: everything else is printed before it.
    ///
    /// # Panics
    /// The system cannot start another thread.
    #[must_use = "it watches for as long as it lives"]
    #[track_caller]
    pub fn new(limit: Duration, report: impl FnOnce() -> String + Send + 'static) -> Self {
        let (cancel, cancelled) = channel();
        let place = Location::caller();
        let thread_name = thread::current().name().unwrap_or("an unnamed thread").to_owned();
        let watch = move || {
            if cancelled.recv_timeout(limit) == Err(RecvTimeoutError::Timeout) {
                say(&format!(
                    "\n{thread_name} hangs: it began at {place} and has not ended within {limit:?}\n{}",
                    threads()
                ));
                let (done, finished) = channel();
                thread::spawn(move || {
                    say(&report());
                    // The receiver may have ended already.
                    let _ = done.send(());
                });
                if finished.recv_timeout(REPORT_TIMEOUT).is_err() {
                    say("no further report: it waits for a lock that another thread holds");
                }
                descendants::end();
                std::process::exit(1);
            }
        };
        let started = thread::Builder::new().name(String::from("watchdog")).spawn(watch);
        Self {
            cancel: Some(cancel),
            thread: Some(started.expect("the system can start a thread")),
        }
    }

    /// Starts a watchdog for a test, with the limit [`DEFAULT_LIMIT`] and without a report.
    ///
    /// # Panics
    /// The system cannot start another thread.
    #[must_use = "it watches for as long as it lives"]
    #[track_caller]
    pub fn for_test() -> Self {
        Self::new(DEFAULT_LIMIT, String::new)
    }
}

/// Writes to stderr itself: what a test prints is kept until its end, and is lost when the process ends before.
fn say(text: &str) {
    // Nobody is left to report to if it fails.
    let _ = writeln!(io::stderr(), "{text}");
}

/// Returns the system's data of each thread: its name, its state, and the kernel function in which it
/// waits.
fn threads() -> String {
    let tasks = fs::read_dir("/proc/self/task").into_iter().flatten().flatten();
    let mut lines: Vec<String> = tasks
        .map(|task| {
            let read = |file: &str| fs::read_to_string(task.path().join(file)).unwrap_or_default();
            let status = read("status");
            let state = status.lines().find_map(|line| line.strip_prefix("State:"));
            format!(
                "  {:16} {:14} {}",
                read("comm").trim(),
                state.unwrap_or("?").trim(),
                read("wchan").trim()
            )
        })
        .collect();
    lines.sort();
    lines.insert(
        0,
        String::from("its threads (name, state, function in the kernel):"),
    );
    lines.join("\n")
}
