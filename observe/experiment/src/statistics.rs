//! Statistics of measures and shares. The same values in any order give the same statistics, to the bit and
//! on every machine. Values that are not finite are left out.
//!
//! It knows no drives and no names.

use rand_pcg::Pcg64Mcg;
use rand_pcg::rand_core::{Rng, SeedableRng};

/// Resamples of the bootstrap: 50 of them are beyond each end of the interval, so that chance moves the ends
/// little.
const BOOTSTRAP_RESAMPLES: usize = 2_000;
/// Probability that an interval leaves out on each side.
const TAIL_PROBABILITY: f64 = 0.025;
/// The quantile of the standard normal distribution at `1 - TAIL_PROBABILITY`.
const Z: f64 = 1.959_963_984_540_054;

/// A 95 % interval.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interval {
    /// The lower end.
    pub low: f64,
    /// The upper end.
    pub high: f64,
}

/// The statistics of a measure.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Statistics {
    /// The number of values.
    pub count: usize,
    /// The least value.
    pub min: f64,
    /// The first and the third quartile, linear between the values next to them.
    pub quartiles: [f64; 2],
    /// The median: the mean of the two middle values if the number is even.
    pub median: f64,
    /// The interval of the median, by percentile bootstrap.
    pub interval: Interval,
    /// The greatest value.
    pub max: f64,
    /// The mean.
    pub mean: f64,
}

/// A share of things.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Share {
    /// The number of things that count.
    pub count: usize,
    /// The number of all things.
    pub total: usize,
    /// The interval of the share, by Wilson's score: within 0 and 1.
    pub interval: Interval,
}

/// Differences between two values of each pair.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Differences {
    /// The number of pairs.
    pub pairs: usize,
    /// The median of the differences.
    pub median: f64,
    /// The interval of the median, by percentile bootstrap.
    pub interval: Interval,
    /// The number of pairs whose value is less than the one compared with.
    pub lower: usize,
    /// The number of pairs whose value is greater than the one compared with.
    pub higher: usize,
}

impl Interval {
    /// Whether a value is within the interval or at one of its ends.
    #[must_use]
    pub fn contains(self, value: f64) -> bool {
        (self.low..=self.high).contains(&value)
    }
}

impl Statistics {
    /// Computes the statistics; `None` without values.
    #[must_use]
    pub fn of(values: impl IntoIterator<Item = f64>) -> Option<Self> {
        let values = sorted(values);
        let (&min, &max) = values.first().zip(values.last())?;
        let sum: f64 = values.iter().sum();
        Some(Self {
            count: values.len(),
            min,
            quartiles: [0.25, 0.75].map(|share| quantile(&values, share)),
            median: median(&values),
            interval: median_interval(&values),
            max,
            // Rounding must not move the mean of equal values beyond them.
            mean: (sum / values.len() as f64).clamp(min, max),
        })
    }
}

impl Share {
    /// Computes the share of `count` among `total`. The share of nothing has the interval from 0 to 1.
    #[must_use]
    pub fn of(count: usize, total: usize) -> Self {
        let interval = match total {
            0 => Interval { low: 0.0, high: 1.0 },
            _ => wilson(count as f64, total as f64),
        };
        Self {
            count,
            total,
            interval,
        }
    }
}

impl Differences {
    /// Computes the differences of pairs of a value and the one compared with; `None` without pairs.
    #[must_use]
    pub fn of(pairs: impl IntoIterator<Item = (f64, f64)>) -> Option<Self> {
        let differences = sorted(pairs.into_iter().map(|(value, base)| value - base));
        if differences.is_empty() {
            return None;
        }
        Some(Self {
            pairs: differences.len(),
            median: median(&differences),
            interval: median_interval(&differences),
            lower: differences.iter().filter(|difference| **difference < 0.0).count(),
            higher: differences.iter().filter(|difference| **difference > 0.0).count(),
        })
    }
}

/// The finite values in their order. Without negative zeros, whose order among zeros would be arbitrary.
fn sorted(values: impl IntoIterator<Item = f64>) -> Vec<f64> {
    let finite = values.into_iter().filter(|value| value.is_finite());
    let mut values: Vec<f64> = finite.map(|value| value + 0.0).collect();
    values.sort_by(f64::total_cmp);
    values
}

/// The quantile of sorted values, linear between the two next to it.
fn quantile(sorted: &[f64], share: f64) -> f64 {
    let place = share * (sorted.len() - 1) as f64;
    let below = sorted[place.floor() as usize];
    let above = sorted[place.ceil() as usize];
    between(below, above, place.fract())
}

fn median(sorted: &[f64]) -> f64 {
    let [below, above] = middle(sorted.len()).map(|place| sorted[place]);
    between(below, above, 0.5)
}

/// The value at a share of the way between two; no rounding leads beyond either.
fn between(below: f64, above: f64, share: f64) -> f64 {
    // Products, since the difference of two large values may not be finite.
    (below * (1.0 - share) + above * share).clamp(below, above)
}

/// The places of the two middle ones of sorted values; equal for an odd number.
fn middle(count: usize) -> [usize; 2] {
    [(count - 1) / 2, count / 2]
}

/// The interval of the median: the percentiles of the medians of resamples with replacement.
fn median_interval(sorted: &[f64]) -> Interval {
    let (first, last) = (sorted[0], sorted[sorted.len() - 1]);
    if first == last {
        return Interval {
            low: first,
            high: last,
        };
    }
    // Always the same resamples: they depend only on the number of values.
    let mut random = Pcg64Mcg::seed_from_u64(0);
    let mut draws = vec![0u32; sorted.len()];
    let mut medians: Vec<f64> = (0..BOOTSTRAP_RESAMPLES)
        .map(|_| resampled_median(sorted, &mut random, &mut draws))
        .collect();
    medians.sort_by(f64::total_cmp);
    Interval {
        low: quantile(&medians, TAIL_PROBABILITY),
        high: quantile(&medians, 1.0 - TAIL_PROBABILITY),
    }
}

/// The median of one resample. `draws` has a place for each value.
fn resampled_median(sorted: &[f64], random: &mut Pcg64Mcg, draws: &mut [u32]) -> f64 {
    draws.fill(0);
    for _ in 0..sorted.len() {
        let place = (u128::from(random.next_u64()) * sorted.len() as u128) >> 64;
        draws[place as usize] += 1;
    }
    // Counting needs no sorting: a value is at all places of the resample that its draws fill.
    let mut filled = 0;
    let mut ends = draws.iter().map(|draws| {
        filled += *draws as usize;
        filled
    });
    let mut reached = 0;
    let mut end = 0;
    let [below, above] = middle(sorted.len()).map(|place| {
        while end <= place {
            end = ends.next().unwrap_or(usize::MAX);
            reached += 1;
        }
        sorted[reached - 1]
    });
    between(below, above, 0.5)
}

/// Wilson's interval: E. B. Wilson, "Probable inference, the law of succession, and statistical inference",
/// Journal of the American Statistical Association 22 (1927).
fn wilson(count: f64, total: f64) -> Interval {
    let share = count / total;
    let scale = 1.0 + Z * Z / total;
    let center = (share + Z * Z / (2.0 * total)) / scale;
    let half = Z / scale * (share * (1.0 - share) / total + Z * Z / (4.0 * total * total)).sqrt();
    // Rounding must not exclude a share of 0 or 1.
    Interval {
        low: (center - half).clamp(0.0, share),
        high: (center + half).clamp(share, 1.0),
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn values() -> impl Strategy<Value = Vec<f64>> {
        prop::collection::vec(-1e3..1e3, 1..40)
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]

        #[test]
        fn the_statistics_are_in_order(values in values()) {
            let found = Statistics::of(values.clone()).unwrap();
            let [lower, upper] = found.quartiles;
            prop_assert_eq!(found.count, values.len());
            prop_assert!(found.min <= lower && lower <= found.median && found.median <= upper && upper <= found.max);
            prop_assert!(found.min <= found.mean && found.mean <= found.max);
            prop_assert!(found.interval.contains(found.median), "{:?}", found);
            prop_assert!(found.min <= found.interval.low && found.interval.high <= found.max);
        }

        #[test]
        fn the_order_of_the_values_changes_nothing(
            (values, shuffled) in values().prop_flat_map(|values| (Just(values.clone()), Just(values).prop_shuffle()))
        ) {
            prop_assert_eq!(Statistics::of(values), Statistics::of(shuffled));
        }

        #[test]
        fn equal_values_give_an_empty_interval(value in -1e3..1e3, count in 1usize..40) {
            let found = Statistics::of(vec![value; count]).unwrap();
            prop_assert_eq!([found.interval.low, found.interval.high, found.mean], [value; 3]);
        }

        #[test]
        fn a_shift_shifts_the_interval(values in prop::collection::vec(-1000i32..1000, 1..40), by in -1000i32..1000) {
            let shift = |by: i32| Statistics::of(values.iter().map(|value| f64::from(value + by))).unwrap().interval;
            let (before, after) = (shift(0), shift(by));
            prop_assert!((before.low + f64::from(by) - after.low).abs() < 1e-9);
            prop_assert!((before.high + f64::from(by) - after.high).abs() < 1e-9);
        }

        #[test]
        fn the_interval_of_a_share_contains_it((count, total) in (1usize..500).prop_flat_map(|total| (0..=total, Just(total)))) {
            let Interval { low, high } = Share::of(count, total).interval;
            let share = count as f64 / total as f64;
            prop_assert!(0.0 <= low && low <= share && share <= high && high <= 1.0 && low < high);
        }

        #[test]
        fn exchanged_pairs_exchange_lower_and_higher(pairs in prop::collection::vec((-9i32..9, -9i32..9), 1..40)) {
            let of = |pairs: &mut dyn Iterator<Item = (i32, i32)>| {
                Differences::of(pairs.map(|(value, base)| (f64::from(value), f64::from(base)))).unwrap()
            };
            let one = of(&mut pairs.iter().copied());
            let other = of(&mut pairs.iter().map(|(value, base)| (*base, *value)));
            prop_assert_eq!((one.pairs, one.lower, one.higher), (other.pairs, other.higher, other.lower));
            prop_assert_eq!(one.median, -other.median);
        }
    }

    #[test]
    fn the_statistics_of_known_values() {
        let found = Statistics::of([4.0, f64::NAN, 1.0, 2.0, 3.0, f64::INFINITY]).unwrap();
        assert_eq!((found.count, found.min, found.max), (4, 1.0, 4.0));
        assert_eq!(
            (found.median, found.quartiles, found.mean),
            (2.5, [1.75, 3.25], 2.5)
        );
        assert_eq!(Statistics::of([f64::NAN]), None);
    }

    /// The resamples belong to the results: another generator would change every interval.
    #[test]
    fn the_interval_is_the_same_to_the_bit() {
        let found = Statistics::of((0..100).map(|number| f64::from(number).sqrt())).unwrap();
        let Interval { low, high } = found.interval;
        assert_eq!((low, high), (6.323_079_006_451_922_4, 7.681_145_747_868_608));
    }

    /// The interval from the ranks of the binomial distribution: the 40th and the 61st of a hundred values.
    #[test]
    fn the_interval_agrees_with_the_one_by_ranks() {
        let found = Statistics::of((1..=100).map(f64::from)).unwrap();
        assert!((found.interval.low - 40.5).abs() <= 1.0, "{found:?}");
        assert!((found.interval.high - 60.5).abs() <= 1.0, "{found:?}");
    }

    #[test]
    fn the_largest_values_do_not_overflow() {
        let found = Statistics::of([f64::MAX, f64::MIN]).unwrap();
        assert_eq!((found.median, found.quartiles[0].is_finite()), (0.0, true));
    }

    #[test]
    fn the_interval_of_a_share_is_wilsons() {
        let rounded = |count, total| {
            let Interval { low, high } = Share::of(count, total).interval;
            [low, high].map(|end| (end * 1e4).round() / 1e4)
        };
        assert_eq!(rounded(98, 100), [0.93, 0.9945]);
        assert_eq!(rounded(0, 10), [0.0, 0.2775]);
        assert_eq!(rounded(0, 0), [0.0, 1.0]);
    }
}
