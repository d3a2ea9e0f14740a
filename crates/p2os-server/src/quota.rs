//! How much of what happens to a robot is told. A client can have thousands of things happen in a second;
//! whoever watches, and the disk that keeps it, cannot. It looks at no event.

use core::time::Duration;

/// Most events of a robot that are told in a second: more than a person reads.
const MOST: u32 = 20;
const SECOND: Duration = Duration::from_secs(1);

/// What is left of a second's share.
#[derive(Debug, Default)]
pub(crate) struct Quota {
    begun: Duration,
    told: u32,
    untold: u64,
}

impl Quota {
    /// Begins a new share when a second of the machine is over; gives how many events of the last one were
    /// left out, if any.
    pub(crate) fn renew(&mut self, now: Duration) -> Option<u64> {
        if now.saturating_sub(self.begun) < SECOND {
            return None;
        }
        (self.begun, self.told) = (now, 0);
        self.rest()
    }

    /// How many events were left out and not spoken of yet, if any.
    pub(crate) fn rest(&mut self) -> Option<u64> {
        Some(std::mem::take(&mut self.untold)).filter(|untold| *untold > 0)
    }

    /// Whether one more event is told.
    pub(crate) fn take(&mut self) -> bool {
        let told = self.told < MOST;
        if told {
            self.told += 1;
        } else {
            self.untold += 1;
        }
        told
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_left_out_is_counted_and_told_once() {
        let mut quota = Quota::default();
        let told = (0..1000).filter(|_| quota.take()).count();
        assert_eq!(told, MOST as usize);
        assert_eq!(quota.renew(SECOND / 2), None, "the second is not over");
        assert_eq!(quota.renew(SECOND), Some(1000 - u64::from(MOST)));
        assert!(quota.take());
        assert_eq!(quota.renew(2 * SECOND), None);
    }
}
