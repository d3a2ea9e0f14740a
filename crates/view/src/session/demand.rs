//! The rates at which a variable or panel was requested lately. It knows neither the requesters nor the
//! subject.

use std::time::{Duration, Instant};

use jde_link::Rate;

/// Minimum time for which a request stays valid.
pub(super) const PATIENCE: Duration = Duration::from_secs(2);
/// Number of checks before which a request stays valid in any case. On a slow machine, frames can be seconds
/// apart, and a requester that could not repeat its request still needs it.
const LOOKS: u32 = 2;

/// The requested rates.
#[derive(Debug, Default)]
pub(super) struct Demand(Vec<RateRequest>);

#[derive(Debug)]
struct RateRequest {
    rate: Rate,
    asked: LastRequest,
}

/// When something was requested last.
#[derive(Clone, Copy, Debug)]
pub(super) struct LastRequest {
    at: Instant,
    /// Checks since then.
    looks: u32,
}

impl LastRequest {
    pub(super) fn new(now: Instant) -> Self {
        Self { at: now, looks: 0 }
    }

    /// Counts a check. Returns whether the request is still valid. Call once a frame.
    pub(super) fn look(&mut self, now: Instant) -> bool {
        self.looks = self.looks.saturating_add(1);
        self.looks < LOOKS || now.saturating_duration_since(self.at) < PATIENCE
    }
}

impl Demand {
    /// Requests a rate.
    pub(super) fn ask(&mut self, rate: Rate, now: Instant) {
        let asked = LastRequest::new(now);
        match self.0.iter_mut().find(|wish| wish.rate == rate) {
            Some(wish) => wish.asked = asked,
            None => self.0.push(RateRequest { rate, asked }),
        }
    }

    /// Removes expired requests and returns the greatest remaining rate, or `None` if none remains. Call once
    /// a frame.
    pub(super) fn greatest(&mut self, now: Instant) -> Option<Rate> {
        self.0.retain_mut(|wish| wish.asked.look(now));
        self.0.iter().map(|wish| wish.rate).max()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_greatest_rate_counts_for_as_long_as_somebody_asks_for_it() {
        let start = Instant::now();
        let mut demand = Demand::default();
        demand.ask(Rate::Hz(5), start);
        demand.ask(Rate::Hz(50), start);
        assert_eq!(demand.greatest(start), Some(Rate::Hz(50)));
        let later = start + PATIENCE;
        demand.ask(Rate::Hz(5), later);
        assert_eq!(demand.greatest(later), Some(Rate::Hz(5)));
        let last = later + PATIENCE;
        assert_eq!(demand.greatest(last), None);
    }

    #[test]
    fn who_asks_in_every_frame_is_not_forgotten_however_rare_frames_are() {
        let mut now = Instant::now();
        let mut demand = Demand::default();
        for _ in 0..5 {
            demand.ask(Rate::Hz(20), now);
            now += 10 * PATIENCE;
            assert_eq!(demand.greatest(now), Some(Rate::Hz(20)));
        }
        assert_eq!(demand.greatest(now), None, "not asked for in the frame before");
    }
}
