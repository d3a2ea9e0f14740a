//! The time to wait before another attempt.

use core::time::Duration;

/// Waiting times that double from the first to the longest.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Backoff {
    /// The wait after the first failed attempt, or after the loss of a device that sent bytes.
    pub initial: Duration,
    /// The longest wait.
    pub max: Duration,
}

impl Backoff {
    /// Returns the wait after `failures` failed attempts in a row.
    #[must_use]
    pub fn delay_after(&self, failures: u32) -> Duration {
        // 2^20 times any first wait exceeds every sensible maximum.
        let doublings = failures.saturating_sub(1).min(20);
        self.initial.saturating_mul(1 << doublings).min(self.max)
    }
}

impl Default for Backoff {
    /// 0.25 s to 4 s. A plug that is pulled and put back is missed only briefly. A device that stays away
    /// costs next to nothing, and is found soon after it is switched on.
    fn default() -> Self {
        Self {
            initial: Duration::from_millis(250),
            max: Duration::from_secs(4),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn waits_double_up_to_the_cap_and_stay_there() {
        let backoff = Backoff::default();
        let waits: Vec<u128> = (0..8)
            .map(|failures| backoff.delay_after(failures).as_millis())
            .collect();
        assert_eq!(waits, [250, 250, 500, 1000, 2000, 4000, 4000, 4000]);
        assert_eq!(backoff.delay_after(u32::MAX), backoff.max);
    }
}
