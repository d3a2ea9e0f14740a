//! Ctrl-C, and other ways in which a process is asked to end: the first stops what runs, the second ends at once.
//! What whoever started the process wants ignored (`nohup`) stays ignored.

use std::io;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};
use signal_hook::iterator::Signals;
use signal_hook::low_level;

use crate::terminal;

/// What a shell adds to the number of the signal that ended a process.
const BY_SIGNAL: i32 = 128;

/// How long a process that has nothing more to stop may take to end by itself after a signal.
const ENDS: Duration = Duration::from_secs(1);

/// What is called at each signal, and whether nobody else listens.
type Heard = Box<dyn Fn(i32, bool) + Send>;

/// All that listen now, by their numbers.
static LISTENERS: Mutex<Vec<(u64, Heard)>> = Mutex::new(Vec::new());

/// Listens to signals while it lives. When nobody listens any more, what is left to be written has a second after a signal, and the
/// process ends.
pub(crate) struct Interrupts {
    number: u64,
}

impl Interrupts {
    /// Calls `stop` at the first signal, from a thread of its own; it must return soon. The second ends the process.
    ///
    /// # Errors
    /// The system refuses to tell of signals.
    pub(crate) fn call(stop: impl Fn() + Send + 'static) -> io::Result<Self> {
        let before = AtomicBool::new(false);
        Self::each(move |signal, _| {
            if before.swap(true, Ordering::Relaxed) {
                end_by(signal);
            }
            stop();
        })
    }

    /// Calls `heard` at each signal with it and whether nobody else listens, from a thread of its own; it must return soon, and neither
    /// begin to listen nor end it.
    ///
    /// # Errors
    /// The system refuses to tell of signals.
    pub(crate) fn each(heard: impl Fn(i32, bool) + Send + 'static) -> io::Result<Self> {
        static NEXT: AtomicU64 = AtomicU64::new(0);
        listen()?;
        let number = NEXT.fetch_add(1, Ordering::Relaxed);
        listeners().push((number, Box::new(heard)));
        Ok(Self { number })
    }
}

/// What it called is not called any more when this returns.
impl Drop for Interrupts {
    fn drop(&mut self) {
        listeners().retain(|(number, _)| *number != self.number);
    }
}

/// Begins to listen, once for as long as the process lives: a signal that was listened to once and is not any more would be ignored.
fn listen() -> io::Result<()> {
    static BEGUN: Mutex<bool> = Mutex::new(false);
    let mut begun = BEGUN.lock().unwrap_or_else(PoisonError::into_inner);
    if *begun {
        return Ok(());
    }
    let minded = [SIGINT, SIGTERM, SIGHUP]
        .into_iter()
        .filter(|signal| !is_ignored(*signal));
    let mut signals = Signals::new(minded)?;
    std::thread::Builder::new()
        .name("signals".to_owned())
        .spawn(move || signals.forever().for_each(take))?;
    *begun = true;
    Ok(())
}

fn take(signal: i32) {
    // Whoever prints for a reader that does not read hears of it too.
    terminal::let_go();
    let is_heard = {
        let listeners = listeners();
        let alone = listeners.len() == 1;
        listeners.iter().for_each(|(_, heard)| heard(signal, alone));
        !listeners.is_empty()
    };
    if !is_heard {
        std::thread::sleep(ENDS);
        if listeners().is_empty() {
            end_by(signal);
        }
    }
}

fn listeners() -> MutexGuard<'static, Vec<(u64, Heard)>> {
    LISTENERS.lock().unwrap_or_else(PoisonError::into_inner)
}

/// What a person does to end this process, in words. A shell has what a script starts in the background ignore Ctrl-C.
pub(crate) fn how_to_end() -> String {
    if is_ignored(SIGINT) {
        let process = std::process::id();
        format!("`kill {process}` ends it: whoever started it, as a script with &, has it ignore Ctrl-C")
    } else {
        "Ctrl-C ends it".to_owned()
    }
}

fn is_ignored(signal: i32) -> bool {
    let ignored = std::fs::read_to_string("/proc/self/status").map_or(0, |status| ignored(&status));
    ignored & (1 << (signal - 1)) != 0
}

/// Ends the process as a signal would.
pub(crate) fn end_by(signal: i32) {
    low_level::exit(BY_SIGNAL + signal);
}

/// The signals that a process was started to ignore, a bit each, from its status as Linux tells it.
fn ignored(status: &str) -> u64 {
    let line = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    line.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok())
        .unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use std::io::{BufRead as _, BufReader};
    use std::process::{Command, Stdio};

    use jde_watchdog::Watchdog;

    use super::{Interrupts, ignored};

    /// Has this test program listen to signals, and no more.
    const LISTENED: &str = "JDE_TEST_LISTENED";

    #[test]
    fn a_signal_after_the_last_who_listened_ends_the_process() {
        let _watchdog = Watchdog::of_a_test();
        if std::env::var_os(LISTENED).is_some() {
            drop(Interrupts::call(|| {}).unwrap());
            println!("\nlistened");
            loop {
                std::thread::park();
            }
        }
        let name = "interrupt::tests::a_signal_after_the_last_who_listened_ends_the_process";
        let mut process = Command::new(std::env::current_exe().unwrap())
            .args(["--exact", name, "--nocapture"])
            .env(LISTENED, "")
            .stdout(Stdio::piped())
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
            ignored("SigBlk:\t0000000000000000\nSigIgn:\t0000000000001001\n"),
            0x1001
        );
        assert_eq!(ignored("no such line"), 0);
    }
}
