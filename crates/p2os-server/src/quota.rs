//! Limits the reported events of a robot. A client can cause thousands of events in a second, too many for a
//! display or a disk. It does not look at the events.

use core::time::Duration;

/// Most reported events of a robot in a second: more than a person reads.
const MOST: u32 = 20;
const SECOND: Duration = Duration::from_secs(1);

/// The rest of the present second's quota.
#[derive(Debug, Default)]
pub(crate) struct Quota {
    begun: Duration,
    told: u32,
    untold: u64,
}

impl Quota {
    /// Starts a new quota when a second of the machine's time is over. Returns the number of events that were
    /// left out since the last report, if any.
    pub(crate) fn renew(&mut self, now: Duration) -> Option<u64> {
        if now.saturating_sub(self.begun) < SECOND {
            return None;
        }
        (self.begun, self.told) = (now, 0);
        self.rest()
    }

    /// Returns the number of events that were left out since the last report, if any.
    pub(crate) fn rest(&mut self) -> Option<u64> {
        Some(std::mem::take(&mut self.untold)).filter(|untold| *untold > 0)
    }

    /// Returns whether one more event is reported.
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
