//! A Kalman filter of a point in the plane with constant velocity. Both axes have the same noise, so one covariance
//! serves both.

/// Position and velocity with their covariance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Filter {
    /// m.
    pub(crate) position: [f64; 2],
    /// m/s.
    pub(crate) velocity: [f64; 2],
    /// Variance of the position along each axis, m².
    pub(crate) variance: f64,
    /// Covariance of position and velocity, m²/s.
    covariance: f64,
    /// Variance of the velocity, m²/s².
    velocity_variance: f64,
}

impl Filter {
    /// Returns a point that may move up to some walking speed.
    pub(crate) const fn new(position: [f64; 2], deviation: f64, speed: f64) -> Self {
        Self {
            position,
            velocity: [0.0; 2],
            variance: deviation * deviation,
            covariance: 0.0,
            velocity_variance: speed * speed,
        }
    }

    /// Moves on by `time` s. `noise` is the power of the acceleration, m²/s³.
    pub(crate) fn predict(&mut self, time: f64, noise: f64) {
        for (position, velocity) in self.position.iter_mut().zip(self.velocity) {
            *position += time * velocity;
        }
        self.variance += 2.0 * time * self.covariance
            + time * time * self.velocity_variance
            + noise * time * time * time / 3.0;
        self.covariance += time * self.velocity_variance + noise * time * time / 2.0;
        self.velocity_variance += noise * time;
    }

    /// Takes a measured position with this standard deviation, m.
    pub(crate) fn update(&mut self, measured: [f64; 2], deviation: f64) {
        let sum = self.variance + deviation * deviation;
        let gains = [self.variance / sum, self.covariance / sum];
        for (axis, measured) in measured.into_iter().enumerate() {
            let error = measured - self.position[axis];
            self.position[axis] += gains[0] * error;
            self.velocity[axis] += gains[1] * error;
        }
        self.velocity_variance -= gains[1] * self.covariance;
        self.covariance *= 1.0 - gains[0];
        self.variance *= 1.0 - gains[0];
    }

    /// Returns the distance to a position that is measured with this standard deviation, m, and the square of the
    /// Mahalanobis distance.
    pub(crate) fn distance(&self, measured: [f64; 2], deviation: f64) -> (f64, f64) {
        let distance = libm::hypot(measured[0] - self.position[0], measured[1] - self.position[1]);
        (
            distance,
            distance * distance / (self.variance + deviation * deviation),
        )
    }

    /// Returns twice the logarithm of how much wider the distribution of such a measurement is than that of an exact
    /// position: what a good fit of a vague position costs.
    pub(crate) fn spread(&self, deviation: f64) -> f64 {
        2.0 * libm::log(1.0 + self.variance / (deviation * deviation))
    }

    /// Stops it where it is.
    pub(crate) fn stop(&mut self, position: [f64; 2]) {
        (self.position, self.velocity) = (position, [0.0; 2]);
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn it_learns_a_velocity_and_goes_on_with_it() {
        let mut filter = Filter::new([0.0, 0.0], 0.1, 1.0);
        for step in 1..=50 {
            filter.predict(0.1, 0.1);
            filter.update([0.08 * f64::from(step), 1.0], 0.05);
        }
        assert!((filter.velocity[0] - 0.8).abs() < 1e-3 && filter.velocity[1].abs() < 1e-3);
        filter.predict(2.0, 0.1);
        assert!((filter.position[0] - 5.6).abs() < 0.01 && (filter.position[1] - 1.0).abs() < 0.01);
    }

    proptest! {
        #[test]
        fn the_covariance_stays_positive_definite(steps in proptest::collection::vec((0.001..5.0, 0.001..1.0), 1..100)) {
            let mut filter = Filter::new([0.0, 0.0], 0.1, 1.0);
            for (time, deviation) in steps {
                filter.predict(time, 0.5);
                filter.update([1.0, -1.0], deviation);
                prop_assert!(filter.variance > 0.0 && filter.velocity_variance > 0.0);
                prop_assert!(filter.covariance * filter.covariance <= filter.variance * filter.velocity_variance * (1.0 + 1e-9));
            }
        }
    }
}
