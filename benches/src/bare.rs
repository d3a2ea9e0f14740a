//! The yardsticks without a framework: threads that sleep until a deadline, and threads that wait on a futex.
//! Written as the system's manual pages recommend, with the finest timers.

use std::num::NonZeroU64;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU32, AtomicU64, Ordering};
use std::time::{Duration, Instant};

use jde_measure::grid::Grid;
use rustix::thread::futex;
use rustix::time::{ClockId, Timespec, clock_gettime};

use crate::live::START;

/// The result of threads that slept until deadlines.
pub(crate) struct Slept {
    /// For each thread, how much too long each sleep was, ns.
    pub(crate) late: Vec<Vec<u64>>,
    /// Processor time of the process during the measurement, ns.
    pub(crate) processor: u64,
}

/// Runs one thread per grid that sleeps until its deadlines. The measurement of processor time begins after
/// the common start.
pub(crate) fn sleepers(grids: &[Grid], time: Duration) -> Slept {
    let over = Arc::new(AtomicBool::new(false));
    let start = now() + nanos(START);
    let threads: Vec<_> = grids
        .iter()
        .map(|grid| {
            let (over, grid) = (Arc::clone(&over), *grid);
            std::thread::spawn(move || sleeper(start + grid.first, grid.period, &over))
        })
        .collect();
    sleep_until(start);
    let before = processor_time();
    std::thread::sleep(time);
    let processor = processor_time() - before;
    over.store(true, Ordering::Relaxed);
    let late = threads
        .into_iter()
        .map(|thread| thread.join().expect("the thread does not panic"))
        .collect();
    Slept { late, processor }
}

fn sleeper(mut due: u64, period: u64, over: &AtomicBool) -> Vec<u64> {
    sharpen_timers();
    let mut late = Vec::with_capacity(10_000);
    while !over.load(Ordering::Relaxed) {
        sleep_until(due);
        let after = now().saturating_sub(due);
        if late.len() < late.capacity() {
            late.push(after);
        }
        // A thread that is late by more than a period skips deadlines, as schemas do.
        due += (after / period + 1) * period;
    }
    late
}

/// Wakes one thread from another once per period, for `time`. Returns how long each wake-up took, ns.
pub(crate) fn hand_over(period: Duration, time: Duration) -> Vec<u64> {
    let (signal, sent, over) = (AtomicU32::new(0), AtomicU64::new(0), AtomicBool::new(false));
    let mut took = Vec::with_capacity(10_000);
    std::thread::scope(|scope| {
        scope.spawn(|| {
            sharpen_timers();
            let (start, mut due) = (Instant::now(), now());
            while start.elapsed() < time {
                due += nanos(period);
                sleep_until(due);
                sent.store(now(), Ordering::Relaxed);
                notify(&signal);
            }
            over.store(true, Ordering::Relaxed);
            notify(&signal);
        });
        let mut seen = 0;
        loop {
            while signal.load(Ordering::Acquire) == seen {
                // The loop checks the value again after any return: a wake-up, a signal of the system, or an
                // earlier change.
                let _ = futex::wait(&signal, futex::Flags::PRIVATE, seen, None);
            }
            seen = signal.load(Ordering::Acquire);
            let after = now();
            if over.load(Ordering::Relaxed) {
                break;
            }
            took.push(after.saturating_sub(sent.load(Ordering::Relaxed)));
        }
    });
    took
}

fn notify(signal: &AtomicU32) {
    signal.fetch_add(1, Ordering::Release);
    // It does not matter whether the other thread waits already.
    let _ = futex::wake(signal, futex::Flags::PRIVATE, 1);
}

/// Returns the processor time of the whole process, ns.
pub(crate) fn processor_time() -> u64 {
    of(clock_gettime(ClockId::ProcessCPUTime))
}

fn sharpen_timers() {
    // A kernel that refuses leaves the timers as they are, for both sides of the comparison.
    let _ = rustix::thread::set_current_timer_slack(NonZeroU64::new(1));
}

/// Returns the system's monotonic time, ns, which is the same for all processes.
pub(crate) fn now() -> u64 {
    of(clock_gettime(ClockId::Monotonic))
}

fn sleep_until(due: u64) {
    let due = Timespec {
        tv_sec: (due / 1_000_000_000) as i64,
        tv_nsec: (due % 1_000_000_000) as i64,
    };
    // No signal interrupts the sleep.
    let _ = rustix::thread::clock_nanosleep_absolute(rustix::thread::ClockId::Monotonic, &due);
}

fn of(time: Timespec) -> u64 {
    time.tv_sec as u64 * 1_000_000_000 + time.tv_nsec as u64
}

fn nanos(time: Duration) -> u64 {
    time.as_nanos() as u64
}
