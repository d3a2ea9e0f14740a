//! Ctrl-C, and other ways in which a process is asked to end: the first stops what runs, the second ends at once.
//! What whoever started the process wants ignored (`nohup`) stays ignored.

use std::io;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;

use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};
use signal_hook::iterator::{self, Signals};
use signal_hook::low_level;

/// What a shell adds to the number of the signal that ended a process.
const BY_SIGNAL: i32 = 128;

/// Listens to signals while it lives.
pub(crate) struct Interrupts {
    signals: iterator::Handle,
    thread: Option<JoinHandle<()>>,
}

impl Interrupts {
    /// Calls `stop` at the first signal, from a thread of its own; it must return soon. The second ends the process.
    ///
    /// # Errors
    /// The system refuses to tell of signals.
    pub(crate) fn call(stop: impl Fn() + Send + 'static) -> io::Result<Self> {
        let before = AtomicBool::new(false);
        Self::each(move |signal| {
            if before.swap(true, Ordering::Relaxed) {
                end_by(signal);
            }
            stop();
        })
    }

    /// Calls `heard` at each signal, from a thread of its own; it must return soon.
    ///
    /// # Errors
    /// The system refuses to tell of signals.
    pub(crate) fn each(heard: impl Fn(i32) + Send + 'static) -> io::Result<Self> {
        let ignored = std::fs::read_to_string("/proc/self/status").map_or(0, |status| ignored(&status));
        let minded = [SIGINT, SIGTERM, SIGHUP]
            .into_iter()
            .filter(|signal| ignored & (1 << (signal - 1)) == 0);
        let mut listener = Signals::new(minded)?;
        let signals = listener.handle();
        let thread = std::thread::Builder::new()
            .name("signals".to_owned())
            .spawn(move || listener.forever().for_each(heard))?;
        Ok(Self {
            signals,
            thread: Some(thread),
        })
    }
}

impl Drop for Interrupts {
    fn drop(&mut self) {
        self.signals.close();
        if let Some(thread) = self.thread.take() {
            // It does nothing that panics.
            let _ = thread.join();
        }
    }
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
    use super::ignored;

    #[test]
    fn ignored_signals_are_read_from_the_status_of_the_process() {
        assert_eq!(
            ignored("SigBlk:\t0000000000000000\nSigIgn:\t0000000000001001\n"),
            0x1001
        );
        assert_eq!(ignored("no such line"), 0);
    }
}
