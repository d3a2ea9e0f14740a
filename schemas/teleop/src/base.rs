//! Drives the base as a person wants, within limits. It looks at no sensor: whoever drives sees where to.

use jde_schema::prelude::*;

use crate::wish::{Drive, counts};

/// A pause after which it speeds up from standing again.
const PAUSE: Duration = Duration::from_millis(300);

/// Drives the base as a person wants, for as long as the wish is renewed.
///
/// It is ready while there is a wish that is not older than its patience, so that a robot whose driver has gone, or cannot be
/// heard, goes back to whoever comes next. Put it first among the roots. Without a wish it stands still.
#[derive(Describe)]
#[schema(motor, period = "50ms", budget = "10ms")]
pub struct Base {
    /// What the person wants; to be written again and again, at least twice in each `patience`.
    #[modulation(default = Drive::NONE)]
    want: Modulation<Drive>,
    /// How old a wish may be and still count: the dead-man's switch.
    #[modulation(default = 0.5, unit = "s", min = 0.05, max = 10.0)]
    patience: Modulation<f64>,
    /// The fastest it drives, ahead, back or sideways.
    #[modulation(default = 0.5, unit = "m/s", min = 0.0)]
    fast: Modulation<f64>,
    /// The fastest it turns.
    #[modulation(default = 1.0, unit = "rad/s", min = 0.0)]
    turn: Modulation<f64>,
    /// How much it speeds up in a second. To slow down it takes as little time as the base needs.
    #[modulation(default = 0.6, unit = "m/s2", min = 0.01)]
    acceleration: Modulation<f64>,
    /// How much faster it turns in a second.
    #[modulation(default = 3.0, unit = "rad/s2", min = 0.01)]
    turn_acceleration: Modulation<f64>,
    /// Speeds of the base.
    #[actuator]
    base: Actuator<Twist>,
    /// What it commanded last, and when.
    last: Option<(Twist, Duration)>,
}

impl Schema for Base {
    fn check(&mut self, cx: &Context) -> Result<Precondition> {
        Ok(self.wanted(cx).is_some().into())
    }

    fn iterate(&mut self, cx: &Context) -> Result {
        let twist = match self.wanted(cx) {
            Some(wanted) => self.limited(cx, &wanted),
            None => Twist::ZERO,
        };
        self.last = Some((twist, cx.now()));
        self.base.command(cx, twist);
        Ok(())
    }
}

impl Base {
    fn wanted(&self, cx: &Context) -> Option<Twist> {
        let want = self.want.sample(cx);
        counts(cx, want.wanted, want.time(), self.patience.get(cx)).then_some(want.twist)
    }

    fn limited(&self, cx: &Context, wanted: &Twist) -> Twist {
        let now = cx.now();
        let fresh = |(_, time): &(Twist, Duration)| now.saturating_sub(*time) <= PAUSE;
        let (last, passed) = match self.last.filter(fresh) {
            Some((last, time)) => (last, now.saturating_sub(time).as_secs_f64()),
            None => (Twist::ZERO, Duration::from_millis(50).as_secs_f64()),
        };
        let linear = Limit {
            most: self.fast.get(cx),
            step: self.acceleration.get(cx) * passed,
        };
        let angular = Limit {
            most: self.turn.get(cx),
            step: self.turn_acceleration.get(cx) * passed,
        };
        let mut twist = Twist::planar(
            linear.of(wanted.linear.x, last.linear.x),
            angular.of(wanted.angular.z, last.angular.z),
        );
        twist.linear.y = linear.of(wanted.linear.y, last.linear.y);
        twist
    }
}

/// How fast something may become.
struct Limit {
    /// The greatest speed.
    most: f64,
    /// How much faster it may be than before.
    step: f64,
}

impl Limit {
    /// What may be commanded of a wish, after `last`: slower at once, faster step by step, and the other way round through 0.
    fn of(&self, wanted: f64, last: f64) -> f64 {
        let wanted = wanted.clamp(-self.most, self.most);
        let before = if wanted * last > 0.0 { last.abs() } else { 0.0 };
        wanted.abs().min(before + self.step).copysign(wanted)
    }
}
