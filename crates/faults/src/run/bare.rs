//! A thread that does nothing but wait for its turns, beside an application: what the machine itself takes from whoever has a period.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// The shortest of the campaign's schemas.
const PERIOD: Duration = Duration::from_millis(10);

/// The thread.
pub(super) struct Bare {
    stop: Arc<AtomicBool>,
    thread: JoinHandle<f64>,
}

impl Bare {
    pub(super) fn start() -> Self {
        let stop = Arc::new(AtomicBool::new(false));
        let told = Arc::clone(&stop);
        let thread = std::thread::spawn(move || {
            let mut due = Instant::now();
            let (mut had, mut owed) = (0_u32, 0_u32);
            while !told.load(Ordering::Relaxed) {
                std::thread::sleep(due.saturating_duration_since(Instant::now()));
                had += 1;
                owed += 1;
                due += PERIOD;
                // Late by whole periods, it skips them as a schema does.
                while due < Instant::now() {
                    due += PERIOD;
                    owed += 1;
                }
            }
            1.0 - f64::from(had) / f64::from(owed.max(1))
        });
        Self { stop, thread }
    }

    /// Ends it; the share of its turns that it lost.
    pub(super) fn lost(self) -> f64 {
        self.stop.store(true, Ordering::Relaxed);
        self.thread.join().unwrap_or(1.0)
    }
}
