//! Ctrl-C and the other signals that request the end of the process: the first stops the running verb, the
//! second ends the process at once. A signal that was ignored at the start (`nohup`) stays ignored.

use std::io;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::Duration;

use parking_lot::{Condvar, Mutex, MutexGuard};
use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};
use signal_hook::iterator::Signals;
use signal_hook::low_level;

use crate as terminal;

/// The shell's exit status of a process that a signal ended is this plus the signal's number.
const SIGNAL_STATUS_BASE: i32 = 128;

/// The time that a process without listeners has to end by itself after a signal.
const GRACE_PERIOD: Duration = Duration::from_secs(1);

/// A listener. Its arguments are the signal, and whether it is the only listener.
type SignalCallback = Box<dyn Fn(i32, bool) + Send>;

/// All current listeners, by number.
static LISTENERS: Mutex<Vec<(u64, SignalCallback)>> = Mutex::new(Vec::new());
/// Notified of each new listener.
static ADDED: Condvar = Condvar::new();

/// Listens to signals until it is dropped. A signal without any listener waits one second for one, in which
/// pending output is written, and then ends the process.
pub struct SignalListener {
    number: u64,
}

impl SignalListener {
    /// Calls `stop` at the first signal, on the signal thread; it must return soon. The second signal ends
    /// the process.
    ///
    /// # Errors
    /// The operating system refuses to deliver signals.
    pub fn on_first(stop: impl Fn() + Send + 'static) -> io::Result<Self> {
        let before = AtomicBool::new(false);
        Self::on_each(move |signal, _| {
            if before.swap(true, Ordering::Relaxed) {
                exit_by_signal(signal);
            }
            stop();
        })
    }

    /// Sets the returned flag at the first signal, and then calls `then` as [`on_first`](Self::on_first) does.
    ///
    /// # Errors
    /// The operating system refuses to deliver signals.
    pub fn flag(then: impl Fn() + Send + 'static) -> io::Result<(Arc<AtomicBool>, Self)> {
        let flag = Arc::new(AtomicBool::new(false));
        let received = Arc::clone(&flag);
        let listener = Self::on_first(move || {
            received.store(true, Ordering::Relaxed);
            then();
        })?;
        Ok((flag, listener))
    }

    /// Calls `callback` at each signal with its number and whether this is the only listener. The call is on
    /// the signal thread. It must return soon, and must neither create nor drop a listener.
    ///
    /// # Errors
    /// The operating system refuses to deliver signals.
    pub fn on_each(callback: impl Fn(i32, bool) + Send + 'static) -> io::Result<Self> {
        static NEXT: AtomicU64 = AtomicU64::new(0);
        let number = NEXT.fetch_add(1, Ordering::Relaxed);
        // Before the handlers are installed: the first signal must find a listener.
        listeners().push((number, Box::new(callback)));
        ADDED.notify_one();
        let listener = Self { number };
        install_handlers()?;
        Ok(listener)
    }
}

/// The listener is not called after this returns.
impl Drop for SignalListener {
    fn drop(&mut self) {
        listeners().retain(|(number, _)| *number != self.number);
    }
}

/// Installs the signal handlers, once for the life of the process: a signal whose handler had been removed
/// again would be ignored.
fn install_handlers() -> io::Result<()> {
    static INSTALLED: Mutex<bool> = Mutex::new(false);
    let mut installed = INSTALLED.lock();
    if *installed {
        return Ok(());
    }
    let handled = [SIGINT, SIGTERM, SIGHUP]
        .into_iter()
        .filter(|signal| !is_ignored(*signal));
    let mut signals = Signals::new(handled)?;
    std::thread::Builder::new()
        .name("signals".to_owned())
        .spawn(move || signals.forever().for_each(dispatch))?;
    *installed = true;
    Ok(())
}

fn dispatch(signal: i32) {
    // A thread that waits for a slow reader of the output must also return.
    terminal::finish_soon();
    let mut listeners = listeners();
    ADDED.wait_while_for(&mut listeners, |listeners| listeners.is_empty(), GRACE_PERIOD);
    if listeners.is_empty() {
        exit_by_signal(signal);
    }
    let alone = listeners.len() == 1;
    listeners.iter().for_each(|(_, callback)| callback(signal, alone));
}

fn listeners() -> MutexGuard<'static, Vec<(u64, SignalCallback)>> {
    LISTENERS.lock()
}

/// Describes how the user ends this process. Shells make background processes of a script ignore Ctrl-C.
pub fn how_to_end() -> String {
    if is_ignored(SIGINT) {
        let process = std::process::id();
        format!(
            "`kill {process}` ends it: it ignores Ctrl-C because its parent does, such as a script that uses &"
        )
    } else {
        "Ctrl-C ends it".to_owned()
    }
}

fn is_ignored(signal: i32) -> bool {
    let ignored = std::fs::read_to_string("/proc/self/status").map_or(0, |status| parse_ignored(&status));
    ignored & (1 << (signal - 1)) != 0
}

/// Ends the process with the exit status of a signal.
pub fn exit_by_signal(signal: i32) {
    low_level::exit(SIGNAL_STATUS_BASE + signal);
}

/// Parses the signals that the process ignores, one bit each, from Linux's `/proc/self/status`.
fn parse_ignored(status: &str) -> u64 {
    let line = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    line.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok())
        .unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use std::io::{BufRead as _, BufReader};
    use std::process::{Command, Stdio};

    use jde_watchdog::Watchdog;
    use signal_hook::consts::SIGTERM;
    use signal_hook::low_level;

    use super::{SignalListener, parse_ignored};

    /// Makes this test program listen to signals without acting on them.
    const LISTENED: &str = "JDE_TEST_LISTENED";

    /// Runs one of these tests in a process of its own, in which [`LISTENED`] is set.
    fn process(test: &str) -> Command {
        let mut process = Command::new(std::env::current_exe().unwrap());
        let name = format!("interrupt::tests::{test}");
        process
            .args(["--exact", &name, "--nocapture"])
            .env(LISTENED, "")
            .stdout(Stdio::piped());
        process
    }

    /// Whether the signal thread of this process has taken a signal and waits, according to the system.
    fn waits_for_a_listener() -> bool {
        let mut threads = std::fs::read_dir("/proc/self/task").unwrap().flatten();
        threads.any(|thread| {
            let read = |file: &str| std::fs::read_to_string(thread.path().join(file)).unwrap_or_default();
            read("comm").trim() == "signals" && read("wchan").contains("futex")
        })
    }

    #[test]
    fn a_signal_between_two_listeners_reaches_the_second() {
        let _watchdog = Watchdog::for_test();
        if std::env::var_os(LISTENED).is_some() {
            drop(SignalListener::on_first(|| {}).unwrap());
            low_level::raise(SIGTERM).unwrap();
            while !waits_for_a_listener() {}
            let _listener = SignalListener::on_first(|| low_level::exit(42)).unwrap();
            loop {
                std::thread::park();
            }
        }
        let mut process = process("a_signal_between_two_listeners_reaches_the_second")
            .spawn()
            .unwrap();
        assert_eq!(process.wait().unwrap().code(), Some(42));
    }

    #[test]
    fn a_signal_without_a_listener_ends_the_process() {
        let _watchdog = Watchdog::for_test();
        if std::env::var_os(LISTENED).is_some() {
            drop(SignalListener::on_first(|| {}).unwrap());
            println!("\nlistened");
            loop {
                std::thread::park();
            }
        }
        let mut process = process("a_signal_without_a_listener_ends_the_process")
            .spawn()
            .unwrap();
        let mut lines = BufReader::new(process.stdout.take().unwrap()).lines();
        assert!(lines.any(|line| line.unwrap() == "listened"));
        let id = process.id().to_string();
        assert!(
            Command::new("kill")
                .args(["-TERM", &id])
                .status()
                .unwrap()
                .success()
        );
        assert_eq!(process.wait().unwrap().code(), Some(143));
    }

    #[test]
    fn ignored_signals_are_read_from_the_status_of_the_process() {
        assert_eq!(
            parse_ignored("SigBlk:\t0000000000000000\nSigIgn:\t0000000000001001\n"),
            0x1001
        );
        assert_eq!(parse_ignored("no such line"), 0);
    }
}
