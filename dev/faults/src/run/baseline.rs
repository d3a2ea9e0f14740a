//! A thread without an application, which only waits for its turns. It measures how many turns the machine
//! itself costs.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// The shortest period of the campaign's schemas.
const SHORTEST_PERIOD: Duration = Duration::from_millis(10);

/// Largest share of all processors used by other programs at which periods are judged.
const MAX_OTHER_LOAD: f64 = 0.25;

/// The measurements during the run of an application.
#[derive(Clone, Copy, Debug)]
pub(super) struct Measured {
    /// The share of turns that the thread lost.
    pub(super) lost: f64,
    /// Other programs used too much of the processors.
    pub(super) is_machine_loaded: bool,
}

/// Processor time since the machine started, in the kernel's ticks.
#[derive(Clone, Copy, Default)]
struct CpuTimes {
    all: u64,
    idle: u64,
    own: u64,
}

/// The measuring thread.
pub(super) struct BaselineThread {
    before: CpuTimes,
    stop: Arc<AtomicBool>,
    thread: JoinHandle<f64>,
}

impl BaselineThread {
    pub(super) fn start() -> Self {
        let stop = Arc::new(AtomicBool::new(false));
        let is_stopped = Arc::clone(&stop);
        let thread = std::thread::spawn(move || {
            let mut due = Instant::now();
            let (mut taken, mut expected) = (0_u32, 0_u32);
            while !is_stopped.load(Ordering::Relaxed) {
                std::thread::sleep(due.saturating_duration_since(Instant::now()));
                taken += 1;
                expected += 1;
                due += SHORTEST_PERIOD;
                // Like a schema, the thread skips whole periods that it missed.
                while due < Instant::now() {
                    due += SHORTEST_PERIOD;
                    expected += 1;
                }
            }
            1.0 - f64::from(taken) / f64::from(expected.max(1))
        });
        Self {
            before: CpuTimes::now(),
            stop,
            thread,
        }
    }

    /// Ends the measurement.
    pub(super) fn end(self) -> Measured {
        self.stop.store(true, Ordering::Relaxed);
        Measured {
            is_machine_loaded: self.before.is_loaded_since(),
            lost: self.thread.join().unwrap_or(1.0),
        }
    }
}

/// Whether other programs use too much of the processors for judging periods. Measures for `time`.
pub(crate) fn is_machine_loaded(time: Duration) -> bool {
    let before = CpuTimes::now();
    std::thread::sleep(time);
    before.is_loaded_since()
}

impl CpuTimes {
    fn is_loaded_since(self) -> bool {
        let now = Self::now();
        let all = now.all.saturating_sub(self.all).max(1);
        let idle = now.idle.saturating_sub(self.idle);
        let own = now.own.saturating_sub(self.own);
        let others = all.saturating_sub(idle).saturating_sub(own);
        others as f64 / all as f64 > MAX_OTHER_LOAD
    }

    fn now() -> Self {
        let numbers = |text: &str| -> Vec<u64> {
            text.split_whitespace()
                .filter_map(|word| word.parse().ok())
                .collect()
        };
        let stat = std::fs::read_to_string("/proc/stat").unwrap_or_default();
        let all = stat.lines().next().and_then(|line| line.strip_prefix("cpu "));
        // user, nice, system, idle, iowait, ...; guest times are included in the first two.
        let all = numbers(all.unwrap_or_default());
        let own = std::fs::read_to_string("/proc/self/stat").unwrap_or_default();
        // After the name, which may contain anything: the state, and ten numbers before user and system.
        let own = numbers(own.rsplit_once(')').map_or("", |(_, rest)| rest));
        Self {
            all: all.iter().take(8).sum(),
            idle: all.iter().skip(3).take(2).sum(),
            own: own.iter().skip(10).take(2).sum(),
        }
    }
}
