//! The rates at which a variable or panel was requested lately. It knows neither the requesters nor the
//! subject.

use std::time::{Duration, Instant};

use jde_link::Rate;

/// Minimum time for which a request stays valid.
pub(super) const PATIENCE: Duration = Duration::from_secs(2);
/// Number of checks before which a request stays valid in any case. On a slow machine, frames can be seconds
/// apart, and a requester that could not repeat its request still needs it.
const MIN_CHECKS: u32 = 2;

/// The requested rates.
#[derive(Debug, Default)]
pub(super) struct Demand(Vec<RateRequest>);

#[derive(Debug)]
struct RateRequest {
    rate: Rate,
    last: LastRequest,
}

/// When something was requested last.
#[derive(Clone, Copy, Debug)]
pub(super) struct LastRequest {
    at: Instant,
    /// Checks since then.
    checks: u32,
}

impl LastRequest {
    pub(super) fn new(now: Instant) -> Self {
        Self { at: now, checks: 0 }
    }

    /// Counts a check. Returns whether the request is still valid. Call once a frame.
    pub(super) fn check(&mut self, now: Instant) -> bool {
        self.checks = self.checks.saturating_add(1);
        self.checks < MIN_CHECKS || now.saturating_duration_since(self.at) < PATIENCE
    }
}

impl Demand {
    /// Requests a rate.
    pub(super) fn request(&mut self, rate: Rate, now: Instant) {
        let last = LastRequest::new(now);
        match self.0.iter_mut().find(|entry| entry.rate == rate) {
            Some(entry) => entry.last = last,
            None => self.0.push(RateRequest { rate, last }),
        }
    }

    /// Removes expired requests and returns the greatest remaining rate, or `None` if none remains. Call once
    /// a frame.
    pub(super) fn greatest(&mut self, now: Instant) -> Option<Rate> {
        self.0.retain_mut(|entry| entry.last.check(now));
        self.0.iter().map(|entry| entry.rate).max()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_greatest_rate_counts_while_it_is_requested() {
        let start = Instant::now();
        let mut demand = Demand::default();
        demand.request(Rate::Hz(5), start);
        demand.request(Rate::Hz(50), start);
        assert_eq!(demand.greatest(start), Some(Rate::Hz(50)));
        let later = start + PATIENCE;
        demand.request(Rate::Hz(5), later);
        assert_eq!(demand.greatest(later), Some(Rate::Hz(5)));
        let end = later + PATIENCE;
        assert_eq!(demand.greatest(end), None);
    }

    #[test]
    fn a_request_in_every_frame_stays_valid_however_rare_the_frames_are() {
        let mut now = Instant::now();
        let mut demand = Demand::default();
        for _ in 0..5 {
            demand.request(Rate::Hz(20), now);
            now += 10 * PATIENCE;
            assert_eq!(demand.greatest(now), Some(Rate::Hz(20)));
        }
        assert_eq!(
            demand.greatest(now),
            None,
            "it was not requested in the previous frame"
        );
    }
}
