//! Limits the reported events of a robot. A client can cause thousands of events in a second, too many for a
//! display or a disk. All kinds of events count alike.

use core::time::Duration;

/// Most reported events of a robot in a second: more than a person reads.
const MAX_EVENTS: u32 = 20;
const ONE_SECOND: Duration = Duration::from_secs(1);

/// The rest of the present second's quota.
#[derive(Debug, Default)]
pub(crate) struct Quota {
    started: Duration,
    reported: u32,
    dropped: u64,
}

impl Quota {
    /// Starts a new quota when a second of the machine's time is over. Returns the number of events that were
    /// dropped since the last report, if any.
    pub(crate) fn renew(&mut self, now: Duration) -> Option<u64> {
        if now.saturating_sub(self.started) < ONE_SECOND {
            return None;
        }
        (self.started, self.reported) = (now, 0);
        self.take_dropped()
    }

    /// Returns the number of events that were dropped since the last report, if any.
    pub(crate) fn take_dropped(&mut self) -> Option<u64> {
        Some(std::mem::take(&mut self.dropped)).filter(|count| *count > 0)
    }

    /// Returns whether one more event is reported.
    pub(crate) fn allow(&mut self) -> bool {
        let is_allowed = self.reported < MAX_EVENTS;
        if is_allowed {
            self.reported += 1;
        } else {
            self.dropped += 1;
        }
        is_allowed
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dropped_events_are_counted_and_reported_once() {
        let mut quota = Quota::default();
        let is_allowed = (0..1000).filter(|_| quota.allow()).count();
        assert_eq!(is_allowed, MAX_EVENTS as usize);
        assert_eq!(quota.renew(ONE_SECOND / 2), None, "the second is not over");
        assert_eq!(quota.renew(ONE_SECOND), Some(1000 - u64::from(MAX_EVENTS)));
        assert!(quota.allow());
        assert_eq!(quota.renew(2 * ONE_SECOND), None);
    }
}
