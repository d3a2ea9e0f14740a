//! Drives the base as a person wishes, within limits. It reads no sensor and avoids no obstacle: the person
//! watches the path.

use jde_schema::prelude::*;

use crate::setpoint::{Drive, is_in_force};

/// Gap between two commands after which acceleration starts from zero speed again.
const PAUSE: Duration = Duration::from_millis(300);

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
    /// Highest increase of the speed per second. Only the base limits decreases.
    #[modulation(default = 0.6, unit = "m/s2", min = 0.01)]
    acceleration: Modulation<f64>,
    /// Highest increase of the turn rate per second.
    #[modulation(default = 3.0, unit = "rad/s2", min = 0.01)]
    turn_acceleration: Modulation<f64>,
    /// Speeds of the base.
    #[actuator]
    base: Actuator<Twist>,
    /// The last command, and its time.
    last: Option<(Twist, Duration)>,
}

impl Schema for Base {
    fn check(&mut self, cx: &Context) -> Result<Precondition> {
        Ok(self.requested_twist(cx).is_some().into())
    }

    fn iterate(&mut self, cx: &Context) -> Result {
        let twist = match self.requested_twist(cx) {
            Some(requested) => self.limited(cx, &requested),
            None => Twist::ZERO,
        };
        self.last = Some((twist, cx.now()));
        self.base.command(cx, twist);
        Ok(())
    }
}

impl Base {
    fn requested_twist(&self, cx: &Context) -> Option<Twist> {
        let wish = self.want.sample(cx);
        is_in_force(cx, wish.wanted, wish.time(), self.patience.get(cx)).then_some(wish.twist)
    }

    fn limited(&self, cx: &Context, requested: &Twist) -> Twist {
        let now = cx.now();
        let fresh = |(_, time): &(Twist, Duration)| now.saturating_sub(*time) <= PAUSE;
        let (last, passed) = match self.last.filter(fresh) {
            Some((last, time)) => (last, now.saturating_sub(time).as_secs_f64()),
            None => (Twist::ZERO, Duration::from_millis(50).as_secs_f64()),
        };
        let linear = Limit {
            max: self.fast.get(cx),
            step: self.acceleration.get(cx) * passed,
        };
        let angular = Limit {
            max: self.turn.get(cx),
            step: self.turn_acceleration.get(cx) * passed,
        };
        let mut twist = Twist::planar(
            linear.of(requested.linear.x, last.linear.x),
            angular.of(requested.angular.z, last.angular.z),
        );
        twist.linear.y = linear.of(requested.linear.y, last.linear.y);
        twist
    }
}

/// The limits of one speed.
struct Limit {
    /// Highest absolute value.
    max: f64,
    /// Highest increase in this step.
    step: f64,
}

impl Limit {
    /// Returns the speed to command for a wish after the speed `last`. It decreases at once, increases step
    /// by step, and passes through 0 when the sign changes.
    fn of(&self, requested: f64, last: f64) -> f64 {
        let target = requested.clamp(-self.max, self.max);
        let before = if target * last > 0.0 { last.abs() } else { 0.0 };
        target.abs().min(before + self.step).copysign(target)
    }
}
