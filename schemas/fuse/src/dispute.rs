//! Whether the gyro and the wheels measure the same turns. A gyro that lies, or is mounted otherwise than stated, is believed
//! by the filter: to it, wheels that contradict it slip.

use core::time::Duration;

use jde_fuse::{Initial, Outcome, State, Wheels};

use crate::push::Push;

/// For so long turns are summed up and compared, s.
const LENGTHS: [f64; 2] = [2.0, 20.0];
/// Deviations from which on a difference is none of those that were expected.
const MOST: f64 = 5.0;
/// By how much the wheels are behind the gyro at most, s, and what they may give, rad.
const LAG: f64 = 0.1;
const GIVE: f64 = 0.05;
/// A turn that both measured: after it, wheels that slipped before are forgiven, rad.
const AGREED: f64 = 0.2;
/// The longest time between two measurements that are compared, s.
const MAX_GAP: f64 = 0.5;

/// The comparison of the gyro with the wheels.
#[derive(Debug, Default)]
pub(crate) struct Dispute {
    /// The sum and the number of the rates of the gyro since the wheels measured, and when it measured last.
    gyro: (f64, f64),
    turned: Option<(Duration, f64)>,
    rolled: Option<Duration>,
    windows: [Window; LENGTHS.len()],
    /// For how long the wheels have slipped by the gyro since both last agreed on a turn, s.
    slipped: f64,
    agreed: f64,
    is_over: bool,
    push: Push,
}

/// What was summed up.
#[derive(Clone, Copy, Debug, Default)]
struct Window {
    time: f64,
    difference: f64,
    turned: f64,
    way: f64,
    variance: f64,
    fastest: f64,
}

impl Dispute {
    /// Takes a turn rate of the gyro without its bias.
    pub(crate) fn turn(&mut self, time: Duration, rate: f64) {
        self.gyro = (self.gyro.0 + rate, self.gyro.1 + 1.0);
        self.turned = Some((time, rate));
    }

    /// Takes what became of the wheels. The filter's constants were expected to be within `expected`, with this deviation
    /// of the bias. Returns the change of the bias, rad/s, and how long it has been there, s, if there is one.
    pub(crate) fn roll(
        &mut self,
        time: Duration,
        (wheels, outcome): (&Wheels, Outcome),
        state: &State,
        expected: &Initial,
        patience: f64,
    ) -> Option<(f64, f64)> {
        let last = self.rolled.replace(time);
        let (sum, count) = core::mem::take(&mut self.gyro);
        let step = last.map_or(f64::INFINITY, |last| time.saturating_sub(last).as_secs_f64());
        let gyro = match self.turned {
            _ if count > 0.0 => Some(sum / count),
            Some((turned, rate)) if time.saturating_sub(turned).as_secs_f64() < LAG => Some(rate),
            _ => None,
        };
        let Some(gyro) = gyro.filter(|_| step < MAX_GAP) else {
            self.windows = Default::default();
            return None;
        };
        let is_pushed = matches!(outcome, Outcome::Slips(_) | Outcome::Pushed(_)) && wheels.is_standing;
        let change = is_pushed.then(|| self.push.add(time, gyro)).flatten();
        if !is_pushed {
            self.push.end();
        }
        match outcome {
            // The gyro measures how the base is moved.
            _ if wheels.is_standing => {}
            Outcome::Slips(_) => {
                (self.slipped, self.agreed) = (self.slipped + step, 0.0);
                self.is_over |= self.slipped > patience;
            }
            Outcome::Taken => self.compare(step, wheels, gyro, expected),
            Outcome::Pushed(_) | Outcome::Refused(_) | Outcome::Invalid => {}
        }
        let is_too_far = |value: f64, deviation: f64| value.abs() > MOST * deviation + 1e-6;
        self.is_over |=
            is_too_far(state.drift, expected.drift) || is_too_far(state.turn_scale, expected.turn_scale);
        change
    }

    fn compare(&mut self, step: f64, wheels: &Wheels, gyro: f64, expected: &Initial) {
        if gyro * wheels.rate > 0.0 {
            self.agreed += step * gyro.abs().min(wheels.rate.abs());
            if self.agreed > AGREED {
                self.slipped = 0.0;
            }
        }
        for (window, length) in self.windows.iter_mut().zip(LENGTHS) {
            window.time += step;
            window.difference += step * (wheels.rate - gyro);
            window.turned += step * gyro.abs();
            window.way += step * wheels.velocity[0].abs();
            window.variance += step * step * wheels.covariance[2][2];
            window.fastest = window.fastest.max(gyro.abs());
            if window.time >= length {
                self.is_over |= window.is_contradiction(expected);
                *window = Window::default();
            }
        }
    }

    /// That the two contradict each other. Which of them is wrong, and so the heading, is not known until a new start.
    pub(crate) fn words(&self) -> Option<&'static str> {
        self.is_over.then_some(
            "wheels and gyro contradict each other: check the gyro, how it is mounted, and `turn_scale_deviation`",
        )
    }

    /// Whether the gyro has shown a turn for long while the wheels stood.
    pub(crate) fn is_pushed(&self) -> bool {
        self.push.lasts()
    }
}

impl Window {
    fn is_contradiction(&self, expected: &Initial) -> bool {
        let parts = [
            expected.turn_scale * self.turned,
            expected.drift * self.way,
            expected.bias * self.time,
        ];
        let variance = self.variance + parts.map(|part| part * part).iter().sum::<f64>();
        self.difference.abs() > MOST * variance.sqrt() + LAG * self.fastest + GIVE
    }
}
