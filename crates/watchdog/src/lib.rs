//! Ends a process in which something waits for ever, and says who was where. For tests and campaigns; no robot runs it.
//!
//! It bounds no behaviour: its limits lie far beyond what any machine needs, so that it tells a hang from a slow machine.

use std::fs;
use std::panic::Location;
use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::thread::{self, JoinHandle};
use std::time::Duration;

/// How long a test may take before it counts as one that hangs: a hundred times what the slowest takes on two busy cores.
pub const HANGS: Duration = Duration::from_secs(300);

/// How long the report may take. It may need a lock that whoever hangs has.
const REPORT: Duration = Duration::from_secs(2);

/// Watches until it is dropped.
#[derive(Debug)]
pub struct Watchdog {
    /// Never sent to: it is closed when this is dropped.
    open: Option<Sender<()>>,
    thread: Option<JoinHandle<()>>,
}

/// Its thread has ended when this returns, and holds nothing of the report any more.
impl Drop for Watchdog {
    fn drop(&mut self) {
        drop(self.open.take());
        if let Some(thread) = self.thread.take() {
            // It does not panic, and if it did there would be nothing to add.
            drop(thread.join());
        }
    }
}

impl Watchdog {
    /// If it is not dropped within `limit`, the process says on stderr what `report` answers and what each of its threads does, and ends
    /// with status 1.
    ///
    /// `report` is called on a thread of its own, and may block: what else is known is said before.
    ///
    /// # Panics
    /// The system has no thread left.
    #[must_use = "it watches for as long as it lives"]
    #[track_caller]
    pub fn new(limit: Duration, report: impl FnOnce() -> String + Send + 'static) -> Self {
        let (open, closed) = channel();
        let place = Location::caller();
        let who = thread::current()
            .name()
            .unwrap_or("a thread without a name")
            .to_owned();
        let watch = move || {
            if closed.recv_timeout(limit) == Err(RecvTimeoutError::Timeout) {
                eprintln!(
                    "\n{who} hangs: it began at {place} and has not ended within {limit:?}\n{}",
                    threads()
                );
                let (tell, told) = channel();
                thread::spawn(move || {
                    eprintln!("{}", report());
                    // Whoever waits for it may be gone.
                    let _ = tell.send(());
                });
                if told.recv_timeout(REPORT).is_err() {
                    eprintln!("what else is known cannot be told: a lock that it needs is taken");
                }
                std::process::exit(1);
            }
        };
        let started = thread::Builder::new().name(String::from("watchdog")).spawn(watch);
        Self {
            open: Some(open),
            thread: Some(started.expect("there is a thread left")),
        }
    }

    /// One of a test, with nothing to add.
    ///
    /// # Panics
    /// The system has no thread left.
    #[must_use = "it watches for as long as it lives"]
    #[track_caller]
    pub fn of_a_test() -> Self {
        Self::new(HANGS, String::new)
    }
}

/// What the system knows of each thread: its name, its state, and the call of the kernel in which it waits.
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
    lines.insert(0, String::from("its threads (name, state, where in the kernel):"));
    lines.join("\n")
}
