//! The machine's time, and the precision with which a thread waits for it.

use rustix::time::{ClockId, clock_gettime};

/// Makes this thread's waits end on time instead of up to 50 us later, which is the kernel's default timer
/// slack.
pub fn sharpen_timers() {
    if let Err(error) = rustix::thread::set_current_timer_slack(std::num::NonZeroU64::new(1)) {
        tracing::debug!("the timer slack cannot be changed: {error}");
    }
}

/// Returns the time of the machine's monotonic clock, the same in every process, ns.
pub fn machine_time() -> u64 {
    let time = clock_gettime(ClockId::Monotonic);
    time.tv_sec as u64 * 1_000_000_000 + time.tv_nsec as u64
}
