//! How much a segment looks like a leg: boosted decision stumps (Friedman, Hastie, Tibshirani, "Additive logistic
//! regression: a statistical view of boosting", 2000), as the sum of one number for each feature and threshold.

use crate::coefficients::STUMPS;
use crate::features::Features;

/// A threshold on one feature, and what each side adds to half of the logarithm of the odds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stump {
    /// The number of the feature.
    pub feature: usize,
    /// The threshold.
    pub threshold: f64,
    /// What a feature below the threshold adds.
    pub below: f64,
    /// What another one adds.
    pub above: f64,
}

/// Returns the probability that a segment with these features is a leg or both legs of a person, from 0 to 1, by some
/// stumps.
#[must_use]
pub fn confidence(stumps: &[Stump], features: &Features) -> f64 {
    let add = |stump: &Stump| {
        if features.0[stump.feature] < stump.threshold {
            stump.below
        } else {
            stump.above
        }
    };
    let sum: f64 = stumps.iter().map(add).sum();
    1.0 / (1.0 + libm::exp(-2.0 * sum))
}

/// Returns the same by the stumps of this crate.
pub(crate) fn leg_confidence(features: &Features) -> f64 {
    confidence(&STUMPS, features)
}
