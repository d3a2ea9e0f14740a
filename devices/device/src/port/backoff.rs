//! The delay before the next attempt.

use core::time::Duration;

/// Delays that double from the first to the longest.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Backoff {
    /// The delay after the first failed attempt, or after the loss of a device that sent bytes.
    pub initial: Duration,
    /// The longest delay.
    pub max: Duration,
}

impl Backoff {
    /// Returns the delay after `failures` failed attempts in a row.
    #[must_use]
    pub fn delay_after(&self, failures: u32) -> Duration {
        // 2^20 times any first delay exceeds every sensible maximum.
        let doublings = failures.saturating_sub(1).min(20);
        self.initial.saturating_mul(1 << doublings).min(self.max)
    }
}

impl Default for Backoff {
    /// 0.25 s to 4 s. A device that is unplugged and plugged in again is missing only briefly. A device
    /// that stays absent costs little, and is found soon after it is switched on.
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
    fn delays_double_up_to_the_maximum() {
        let backoff = Backoff::default();
        let delays: Vec<u128> = (0..8)
            .map(|failures| backoff.delay_after(failures).as_millis())
            .collect();
        assert_eq!(delays, [250, 250, 500, 1000, 2000, 4000, 4000, 4000]);
        assert_eq!(backoff.delay_after(u32::MAX), backoff.max);
    }
}
