//! Limits the reported events of a robot. A client can cause thousands of events in a second, too many for a
//! display or a disk. It does not look at the events.

use core::time::Duration;

/// Most reported events of a robot in a second: more than a person reads.
const MAX_EVENTS: u32 = 20;
const SECOND: Duration = Duration::from_secs(1);

/// The rest of the present second's quota.
#[derive(Debug, Default)]
pub(crate) struct Quota {
    started: Duration,
    reported: u32,
    dropped: u64,
}

impl Quota {
    /// Starts a new quota when a second of the machine's time is over. Returns the number of events that were
    /// left out since the last report, if any.
    pub(crate) fn renew(&mut self, now: Duration) -> Option<u64> {
        if now.saturating_sub(self.started) < SECOND {
            return None;
        }
        (self.started, self.reported) = (now, 0);
        self.take_dropped()
    }

    /// Returns the number of events that were left out since the last report, if any.
    pub(crate) fn take_dropped(&mut self) -> Option<u64> {
        Some(std::mem::take(&mut self.dropped)).filter(|untold| *untold > 0)
    }

    /// Returns whether one more event is reported.
    pub(crate) fn allow(&mut self) -> bool {
        let told = self.reported < MAX_EVENTS;
        if told {
            self.reported += 1;
        } else {
            self.dropped += 1;
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
        let told = (0..1000).filter(|_| quota.allow()).count();
        assert_eq!(told, MAX_EVENTS as usize);
        assert_eq!(quota.renew(SECOND / 2), None, "the second is not over");
        assert_eq!(quota.renew(SECOND), Some(1000 - u64::from(MAX_EVENTS)));
        assert!(quota.allow());
        assert_eq!(quota.renew(2 * SECOND), None);
    }
}
