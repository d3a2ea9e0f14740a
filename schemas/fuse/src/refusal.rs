//! Positions that are refused: after a while they are right, if they agree with each other.

use core::time::Duration;

use crate::FIX_TIMEOUT;

/// What a way by the estimate may err by while positions are refused, as a fraction.
const WAY_ERROR: f64 = 0.2;
/// Deviations by which two positions differ from the way between them.
const MOST: f64 = 5.0;

/// Positions that were refused, each soon after the one before.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Refusal {
    since: Duration,
    last: Duration,
    /// The first of them, and where the robot was by the estimate.
    measured: [f64; 2],
    estimated: [f64; 2],
}

impl Refusal {
    pub(crate) const fn new(now: Duration, measured: [f64; 2], estimated: [f64; 2]) -> Self {
        Self {
            since: now,
            last: now,
            measured,
            estimated,
        }
    }

    /// Takes another one. One that does not agree with those before begins anew: outliers are no place.
    pub(crate) fn add(self, now: Duration, measured: [f64; 2], estimated: [f64; 2], deviation: f64) -> Self {
        let way = |from: [f64; 2], to: [f64; 2]| libm::hypot(to[0] - from[0], to[1] - from[1]);
        let went = way(self.estimated, estimated);
        let differs = (way(self.measured, measured) - went).abs();
        if self.is_old(now) || differs.is_nan() || differs > MOST * deviation + WAY_ERROR * went {
            return Self::new(now, measured, estimated);
        }
        Self { last: now, ..self }
    }

    fn is_old(&self, now: Duration) -> bool {
        now.saturating_sub(self.last).as_secs_f64() > FIX_TIMEOUT
    }

    /// Whether it has lasted for longer than `patience` s, and still does.
    pub(crate) fn lasts(&self, now: Duration, patience: f64) -> bool {
        !self.is_old(now) && self.last.saturating_sub(self.since).as_secs_f64() > patience
    }
}
