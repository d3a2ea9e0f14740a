//! How long to wait before another attempt.

use core::time::Duration;

/// Waiting times that double from a first to a last one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Backoff {
    /// After the first attempt that failed, or when a device that spoke is lost.
    pub first: Duration,
    /// The longest.
    pub most: Duration,
}

impl Backoff {
    /// How long to wait after so many attempts that failed in a row.
    #[must_use]
    pub fn after(&self, failures: u32) -> Duration {
        // 2^20 times anything is beyond every sensible cap.
        let doublings = failures.saturating_sub(1).min(20);
        self.first.saturating_mul(1 << doublings).min(self.most)
    }
}

impl Default for Backoff {
    /// 0.25 s, so that a plug pulled and put back is not noticed for long, up to 4 s, so that a device that
    /// stays away costs next to nothing and is still met by somebody who switches it on and waits.
    fn default() -> Self {
        Self {
            first: Duration::from_millis(250),
            most: Duration::from_secs(4),
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
            .map(|failures| backoff.after(failures).as_millis())
            .collect();
        assert_eq!(waits, [250, 250, 500, 1000, 2000, 4000, 4000, 4000]);
        assert_eq!(backoff.after(u32::MAX), backoff.most);
    }
}
