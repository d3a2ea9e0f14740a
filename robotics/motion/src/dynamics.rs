//! How a base follows its commands: limits of acceleration, and a lag.

use jde_types::Value;
use thiserror::Error;

/// How a base follows a command. It strives for the command within limits of acceleration, and its velocity follows
/// what it strives for as a first-order system. A driver exports what it knows of its base; 0 is unknown.
#[derive(Clone, Copy, Debug, Default, PartialEq, Value)]
#[repr(C)]
#[value(name = "jde_msgs/msg/BaseDynamics")]
pub struct BaseDynamics {
    /// Greatest growth of a speed.
    #[value(unit = "m/s2")]
    pub acceleration: f64,
    /// Greatest decline of a speed.
    #[value(unit = "m/s2")]
    pub deceleration: f64,
    /// Greatest growth of the turn rate.
    #[value(unit = "rad/s2")]
    pub turn_acceleration: f64,
    /// Greatest decline of the turn rate.
    #[value(unit = "rad/s2")]
    pub turn_deceleration: f64,
    /// The time constant by which the velocity follows: after this time 63 % of a step are done.
    #[value(unit = "s")]
    pub lag: f64,
}

/// A number with which no motion can be predicted.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
#[error("the {name} of the base is {value}: expected a finite number above 0")]
pub struct DynamicsError {
    name: &'static str,
    value: f64,
}

impl BaseDynamics {
    /// Returns these numbers, and where one is unknown, that of `others`.
    #[must_use]
    pub fn or(&self, others: &Self) -> Self {
        let known = |own: f64, other: f64| if own == 0.0 { other } else { own };
        Self {
            acceleration: known(self.acceleration, others.acceleration),
            deceleration: known(self.deceleration, others.deceleration),
            turn_acceleration: known(self.turn_acceleration, others.turn_acceleration),
            turn_deceleration: known(self.turn_deceleration, others.turn_deceleration),
            lag: known(self.lag, others.lag),
        }
    }

    /// Whether each limit is finite and above 0, and the lag finite and not below 0.
    #[must_use]
    pub(crate) fn is_valid(&self) -> bool {
        self.check().is_ok()
    }

    /// Checks that each limit is finite and above 0, and the lag finite and not below 0.
    ///
    /// # Errors
    /// The first number that is not, with its value.
    pub fn check(&self) -> Result<(), DynamicsError> {
        let numbers = [
            ("acceleration", self.acceleration),
            ("deceleration", self.deceleration),
            ("turn_acceleration", self.turn_acceleration),
            ("turn_deceleration", self.turn_deceleration),
            ("lag", self.lag),
        ];
        let is_valid =
            |name, value: f64| value.is_finite() && (value > 0.0 || (name == "lag" && value == 0.0));
        let wrong = numbers.into_iter().find(|(name, value)| !is_valid(*name, *value));
        wrong.map_or(Ok(()), |(name, value)| Err(DynamicsError { name, value }))
    }

    /// Returns the speed from which the base still stops within `distance` m.
    #[must_use]
    pub fn arrival(&self, distance: f64) -> f64 {
        let slowing = self.deceleration;
        let square = self.lag * self.lag + 2.0 * distance.max(0.0) / slowing;
        slowing * (square.sqrt() - self.lag)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const DYNAMICS: BaseDynamics = BaseDynamics {
        acceleration: 1.0,
        deceleration: 2.0,
        turn_acceleration: 3.0,
        turn_deceleration: 3.0,
        lag: 0.2,
    };

    #[test]
    fn what_one_does_not_know_is_that_of_the_other() {
        let known = BaseDynamics {
            deceleration: 5.0,
            ..BaseDynamics::default()
        };
        let both = known.or(&DYNAMICS);
        assert_eq!((both.acceleration, both.deceleration, both.lag), (1.0, 5.0, 0.2));
        assert!(both.is_valid() && !known.is_valid());
    }

    #[test]
    fn a_number_with_which_nothing_can_be_predicted_is_named_with_its_value() {
        let check = |change: fn(&mut BaseDynamics)| {
            let mut dynamics = DYNAMICS;
            change(&mut dynamics);
            dynamics.check().map_err(|error| error.to_string())
        };
        assert_eq!(check(|dynamics| dynamics.lag = 0.0), Ok(()));
        let named = |name, value| {
            Err(format!(
                "the {name} of the base is {value}: expected a finite number above 0"
            ))
        };
        assert_eq!(check(|dynamics| dynamics.lag = -0.1), named("lag", "-0.1"));
        assert_eq!(
            check(|dynamics| dynamics.deceleration = -1.0),
            named("deceleration", "-1")
        );
        let unknown = check(|dynamics| dynamics.turn_acceleration = f64::NAN);
        assert_eq!(unknown, named("turn_acceleration", "NaN"));
    }

    #[test]
    fn it_stops_within_the_way_of_its_lag_and_of_its_deceleration() {
        for distance in [0.0, 0.1, 2.0] {
            let speed = DYNAMICS.arrival(distance);
            let way = 0.2 * speed + speed * speed / 4.0;
            assert!((way - distance).abs() < 1e-9, "{speed} m/s within {distance} m");
        }
    }
}
