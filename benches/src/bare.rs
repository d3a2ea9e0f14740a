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
    let ended = Arc::new(AtomicBool::new(false));
    let start = now() + nanos(START);
    let threads: Vec<_> = grids
        .iter()
        .map(|grid| {
            let (ended, grid) = (Arc::clone(&ended), *grid);
            std::thread::spawn(move || sleeper(start + grid.first, grid.period, &ended))
        })
        .collect();
    sleep_until(start);
    let before = processor_time();
    std::thread::sleep(time);
    let processor = processor_time() - before;
    ended.store(true, Ordering::Relaxed);
    let late = threads
        .into_iter()
        .map(|thread| thread.join().expect("the thread returns"))
        .collect();
    Slept { late, processor }
}

fn sleeper(mut deadline: u64, period: u64, ended: &AtomicBool) -> Vec<u64> {
    set_finest_timers();
    let mut late = Vec::with_capacity(10_000);
    while !ended.load(Ordering::Relaxed) {
        sleep_until(deadline);
        let after = now().saturating_sub(deadline);
        if late.len() < late.capacity() {
            late.push(after);
        }
        // A thread that is late by more than a period skips deadlines, as schemas do.
        deadline += (after / period + 1) * period;
    }
    late
}

/// Wakes one thread from another once per period, for `time`. Returns how long each wake-up took, ns.
pub(crate) fn measure_wakeups(period: Duration, time: Duration) -> Vec<u64> {
    let (counter, sent, ended) = (AtomicU32::new(0), AtomicU64::new(0), AtomicBool::new(false));
    let mut durations = Vec::with_capacity(10_000);
    std::thread::scope(|scope| {
        scope.spawn(|| {
            set_finest_timers();
            let (start, mut deadline) = (Instant::now(), now());
            while start.elapsed() < time {
                deadline += nanos(period);
                sleep_until(deadline);
                sent.store(now(), Ordering::Relaxed);
                notify(&counter);
            }
            ended.store(true, Ordering::Relaxed);
            notify(&counter);
        });
        let mut last = 0;
        loop {
            while counter.load(Ordering::Acquire) == last {
                // The loop checks the value again after any return: a wake-up, a signal, or an earlier
                // notification.
                let _ = futex::wait(&counter, futex::Flags::PRIVATE, last, None);
            }
            last = counter.load(Ordering::Acquire);
            let after = now();
            if ended.load(Ordering::Relaxed) {
                break;
            }
            durations.push(after.saturating_sub(sent.load(Ordering::Relaxed)));
        }
    });
    durations
}

fn notify(counter: &AtomicU32) {
    counter.fetch_add(1, Ordering::Release);
    // It does not matter whether the other thread waits already.
    let _ = futex::wake(counter, futex::Flags::PRIVATE, 1);
}

/// Returns the processor time of the whole process, ns.
pub(crate) fn processor_time() -> u64 {
    as_nanos(clock_gettime(ClockId::ProcessCPUTime))
}

fn set_finest_timers() {
    // A kernel that refuses leaves the timers as they are, for both sides of the comparison.
    let _ = rustix::thread::set_current_timer_slack(NonZeroU64::new(1));
}

/// Returns the system's monotonic time, ns, which is the same for all processes.
pub(crate) fn now() -> u64 {
    as_nanos(clock_gettime(ClockId::Monotonic))
}

fn sleep_until(deadline: u64) {
    let deadline = Timespec {
        tv_sec: (deadline / 1_000_000_000) as i64,
        tv_nsec: (deadline % 1_000_000_000) as i64,
    };
    // No signal interrupts the sleep.
    let _ = rustix::thread::clock_nanosleep_absolute(rustix::thread::ClockId::Monotonic, &deadline);
}

fn as_nanos(time: Timespec) -> u64 {
    time.tv_sec as u64 * 1_000_000_000 + time.tv_nsec as u64
}

fn nanos(time: Duration) -> u64 {
    time.as_nanos() as u64
}
