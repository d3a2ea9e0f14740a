//! The machine's time, and how soon a thread runs once it is due.

use rustix::time::{ClockId, clock_gettime};

/// The slice of the processor that a thread asks for, ns: the least that Linux grants.
const PROCESSOR_SLICE: u64 = 100_000;

/// Makes this thread run soon once it is due. Its waits end on time, and not up to 50 us later, which is the default
/// slack of timers. From Linux 6.12 on, its slices of the processor are short, so it need not wait until others that
/// compute have used theirs, of some ms. Its share of the processor stays, and so does a policy other than the usual one.
/// Threads and processes that it starts have the same slices.
pub fn run_when_due() {
    if let Err(error) = rustix::thread::set_current_timer_slack(std::num::NonZeroU64::new(1)) {
        tracing::debug!("the timer slack cannot be changed: {error}");
    }
    if let Err(error) = request_short_slices() {
        tracing::debug!("the slices of the processor stay as they are: {error}");
    }
}

#[allow(unsafe_code, reason = "no library has this system call")]
fn request_short_slices() -> std::io::Result<()> {
    let mut attributes = scheduling()?;
    if attributes.sched_policy != libc::SCHED_OTHER.cast_unsigned() {
        return Ok(());
    }
    attributes.sched_runtime = PROCESSOR_SLICE;
    // SAFETY: the attributes state their size and live until the call returns.
    match unsafe { libc::syscall(libc::SYS_sched_setattr, 0, &raw const attributes, 0) } {
        0 => Ok(()),
        _ => Err(std::io::Error::last_os_error()),
    }
}

/// Returns how this thread is scheduled.
#[allow(unsafe_code, reason = "no library has this system call")]
fn scheduling() -> std::io::Result<libc::sched_attr> {
    let size = size_of::<libc::sched_attr>() as u32;
    // SAFETY: zeros are valid in each of its fields, which are numbers.
    let mut attributes: libc::sched_attr = unsafe { std::mem::zeroed() };
    // SAFETY: room for the attributes, and its size.
    match unsafe { libc::syscall(libc::SYS_sched_getattr, 0, &raw mut attributes, size, 0) } {
        0 => Ok(attributes),
        _ => Err(std::io::Error::last_os_error()),
    }
}

/// Returns the time of the machine's monotonic clock, the same in every process, ns.
pub fn machine_time() -> u64 {
    let time = clock_gettime(ClockId::Monotonic);
    time.tv_sec as u64 * 1_000_000_000 + time.tv_nsec as u64
}

#[cfg(test)]
mod tests {
    use super::{PROCESSOR_SLICE, run_when_due, scheduling};

    #[test]
    fn a_thread_has_short_slices_where_linux_grants_them_and_keeps_its_share() {
        // Some sandboxes do not have the call.
        let Ok(before) = scheduling() else {
            return run_when_due();
        };
        run_when_due();
        let after = scheduling().unwrap();
        assert_eq!(
            (after.sched_policy, after.sched_nice),
            (before.sched_policy, before.sched_nice)
        );
        let release = std::fs::read_to_string("/proc/sys/kernel/osrelease").unwrap();
        let mut numbers = release.split('.').map_while(|number| number.parse::<u32>().ok());
        let is_granted = (numbers.next(), numbers.next()) >= (Some(6), Some(12));
        if is_granted && after.sched_policy == libc::SCHED_OTHER.cast_unsigned() {
            assert_eq!(after.sched_runtime, PROCESSOR_SLICE, "{release}");
        }
    }
}
