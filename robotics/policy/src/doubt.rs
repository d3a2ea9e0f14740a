//! How unsure a network is of what it computed.

use crate::file::{Doubt, DoubtKind};

impl Doubt {
    /// Returns the doubt that an output shows, of which each row of `width` numbers is of one member.
    pub(crate) fn of(&self, output: &[f32], width: usize) -> f64 {
        match self.kind {
            DoubtKind::Number => f64::from(output[self.pick.index]),
            DoubtKind::Spread => (0..width).map(|at| spread(output, width, at)).fold(0.0, f64::max),
        }
    }

    /// Returns how sure the policy is at a doubt: 1 up to `certain`, and 0 from `unsure` on.
    pub(crate) fn certainty(&self, doubt: f64) -> f64 {
        ((self.unsure - doubt) / (self.unsure - self.certain)).clamp(0.0, 1.0)
    }
}

/// The standard deviation among the members of one number.
fn spread(output: &[f32], width: usize, at: usize) -> f64 {
    let numbers = || {
        output
            .iter()
            .skip(at)
            .step_by(width)
            .map(|number| f64::from(*number))
    };
    let count = numbers().count() as f64;
    let mean = numbers().sum::<f64>() / count;
    (numbers()
        .map(|number| (number - mean) * (number - mean))
        .sum::<f64>()
        / count)
        .sqrt()
}
