//! Drives the base as a person wishes, within limits. It reads no sensor and avoids no obstacle: the person
//! watches the path.

use jde_schema::prelude::*;

use crate::ramp::{Limits, Ramp};
use crate::setpoint::{Drive, is_in_force};

/// Drives the base as a person wishes, for as long as the wish is renewed.
///
/// It is ready while the wish is not older than `patience`. When the person leaves or the connection
/// fails, the wish expires and another schema can win. Place it first among the roots. An iteration without a
/// valid wish commands zero speed.
#[derive(Describe)]
#[schema(motor, period = "50ms", budget = "10ms")]
pub struct Base {
    /// The wish of the person. The operator writes it at least twice in each `patience`.
    #[modulation(default = Drive::NONE)]
    want: Modulation<Drive>,
    /// Oldest wish that counts: the dead-man's switch.
    #[modulation(default = 0.5, unit = "s", min = 0.05, max = 10.0)]
    patience: Modulation<f64>,
    /// Highest speed ahead, back or sideways.
    #[modulation(default = 0.5, unit = "m/s", min = 0.0)]
    fast: Modulation<f64>,
    /// Highest turn rate.
    #[modulation(default = 1.0, unit = "rad/s", min = 0.0)]
    turn: Modulation<f64>,
    /// Highest increase of the speed per second. Decreases are not limited here, only by the base.
    #[modulation(default = 0.6, unit = "m/s2", min = 0.01)]
    acceleration: Modulation<f64>,
    /// Highest increase of the turn rate per second.
    #[modulation(default = 3.0, unit = "rad/s2", min = 0.01)]
    turn_acceleration: Modulation<f64>,
    /// Speeds of the base.
    #[actuator]
    base: Actuator<Twist>,
    ramp: Ramp,
}

impl Schema for Base {
    fn check(&mut self, cx: &Context) -> Result<Precondition> {
        Ok(self.active_wish(cx).is_some().into())
    }

    fn iterate(&mut self, cx: &Context) -> Result {
        let twist = match self.active_wish(cx) {
            Some(wish) => self.ramp.follow(cx.now(), &wish, &self.limits(cx)),
            None => self.ramp.stand(cx.now()),
        };
        self.base.command(cx, twist);
        Ok(())
    }
}

impl Base {
    fn active_wish(&self, cx: &Context) -> Option<Twist> {
        let wish = self.want.sample(cx);
        is_in_force(cx, wish.wanted, wish.time(), self.patience.get(cx)).then_some(wish.twist)
    }

    fn limits(&self, cx: &Context) -> Limits {
        Limits {
            speed: self.fast.get(cx),
            turn: self.turn.get(cx),
            acceleration: self.acceleration.get(cx),
            turn_acceleration: self.turn_acceleration.get(cx),
        }
    }
}
