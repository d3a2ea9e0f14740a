//! How the measurements of a sensor arrive: late, at changing intervals, or not at all.
//!
//! A measurement is stamped with the time at which it was made. Its values do not depend on its delivery.

use std::time::Duration;

use crate::error::{WorldError, check};
use crate::random::Noise;

/// The delivery of the measurements of a sensor. By default each arrives at once.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Delivery {
    /// The least time from a measurement to its arrival, in seconds.
    pub latency: f64,
    /// The greatest time beyond the latency, in seconds. All times up to it are equally probable.
    pub jitter: f64,
    /// The part of the measurements that never arrive.
    pub dropped: f64,
}

impl Delivery {
    /// Checks every number.
    ///
    /// # Errors
    /// The first number that is invalid.
    pub fn check(&self) -> Result<(), WorldError> {
        let seconds = |value: f64| (0.0..=10.0).contains(&value);
        check("latency", self.latency, "0 to 10 s", seconds)?;
        check("jitter", self.jitter, "0 to 10 s", seconds)?;
        check("dropped", self.dropped, "0 to 1", |value| {
            (0.0..=1.0).contains(&value)
        })
    }

    /// Returns how long a measurement takes to arrive; `None` for one that never does.
    pub(crate) fn delay(&self, noise: &Noise) -> Option<Duration> {
        if *self == Self::default() {
            return Some(Duration::ZERO);
        }
        let seconds = self.latency + self.jitter * noise.uniform(0);
        (noise.uniform(1) >= self.dropped).then(|| Duration::from_secs_f64(seconds))
    }
}
