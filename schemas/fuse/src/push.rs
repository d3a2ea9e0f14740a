//! A gyro that shows a turn while the wheels stand: somebody moves the base, or the bias is another one than was learned. A
//! hand does not turn steadily.

use core::time::Duration;

/// For so long a turn must be steady to be a bias: so many means of a second each.
const MEANS: usize = 4;
/// By how much these means differ at most, rad/s.
const STEADY: f64 = 0.01;
/// A push of less is over before it says anything, s.
const SHORT: f64 = 1.0;

/// What the gyro showed while the wheels stood.
#[derive(Debug, Default)]
pub(crate) struct Push {
    since: Option<Duration>,
    last: Duration,
    /// The sum and the number of the rates of this second, and when it began.
    second: (f64, f64, Duration),
    means: Vec<f64>,
}

impl Push {
    /// Takes a rate without the bias, rad/s. Returns its mean and since when it has been, s, if it is a bias.
    pub(crate) fn add(&mut self, now: Duration, rate: f64) -> Option<(f64, f64)> {
        let since = *self.since.get_or_insert_with(|| {
            self.second = (0.0, 0.0, now);
            now
        });
        self.last = now;
        let (sum, count, began) = &mut self.second;
        (*sum, *count) = (*sum + rate, *count + 1.0);
        if now.saturating_sub(*began).as_secs_f64() < 1.0 {
            return None;
        }
        if self.means.len() == MEANS {
            self.means.remove(0);
        }
        self.means.push(*sum / *count);
        self.second = (0.0, 0.0, now);
        let [least, most] = (self.means.iter())
            .fold([f64::INFINITY, f64::NEG_INFINITY], |[least, most], mean| {
                [least.min(*mean), most.max(*mean)]
            });
        (self.means.len() == MEANS && most - least < STEADY).then(|| {
            let mean = self.means.iter().sum::<f64>() / MEANS as f64;
            self.means.clear();
            (mean, now.saturating_sub(since).as_secs_f64())
        })
    }

    /// The base stands, or its wheels move.
    pub(crate) fn end(&mut self) {
        self.since = None;
        self.means.clear();
    }

    /// Whether it has lasted.
    pub(crate) fn lasts(&self) -> bool {
        (self.since).is_some_and(|since| self.last.saturating_sub(since).as_secs_f64() > SHORT)
    }
}
