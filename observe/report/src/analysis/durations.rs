//! Statistics of durations: exact mean and worst, quantiles within two percent, in memory that does not
//! depend on their number.

use jde_core::Nanos;

/// Bins per doubling: each is 2.2 % wide.
const BINS_PER_DOUBLING: f64 = 32.0;

/// Durations.
#[derive(Clone, Debug, Default)]
pub(crate) struct Durations {
    bins: Vec<u64>,
    count: u64,
    sum: u128,
    worst: Nanos,
}

impl Durations {
    pub(crate) fn add(&mut self, time: Nanos) {
        let bin = ((time.max(1) as f64).log2() * BINS_PER_DOUBLING) as usize;
        if self.bins.len() <= bin {
            self.bins.resize(bin + 1, 0);
        }
        self.bins[bin] += 1;
        self.count += 1;
        self.sum += u128::from(time);
        self.worst = self.worst.max(time);
    }

    pub(crate) fn count(&self) -> u64 {
        self.count
    }

    /// The sum, ns.
    pub(crate) fn sum(&self) -> u128 {
        self.sum
    }

    /// The mean, ns; none without durations.
    pub(crate) fn mean(&self) -> Option<f64> {
        (self.count > 0).then(|| self.sum as f64 / self.count as f64)
    }

    /// The longest, ns; none without durations.
    pub(crate) fn worst(&self) -> Option<f64> {
        (self.count > 0).then_some(self.worst as f64)
    }

    /// The duration that this share of all does not exceed, ns; none without durations.
    pub(crate) fn quantile(&self, share: f64) -> Option<f64> {
        let rank = (self.count as f64 * share).ceil().max(1.0) as u64;
        let mut seen = 0;
        let bin = self.bins.iter().position(|count| {
            seen += count;
            seen >= rank
        })?;
        // The geometric middle of the bin.
        Some(
            ((bin as f64 + 0.5) / BINS_PER_DOUBLING)
                .exp2()
                .min(self.worst as f64),
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_are_right_within_two_percent() {
        let mut durations = Durations::default();
        for ms in 1..=1000_u64 {
            durations.add(ms * 1_000_000);
        }
        for share in [0.01, 0.5, 0.9, 0.99, 1.0] {
            let found = durations.quantile(share).unwrap() / 1e9;
            assert!((found / share - 1.0).abs() < 0.022, "{share}: {found}");
        }
        assert_eq!(durations.mean(), Some(500.5e6));
        assert_eq!(durations.worst(), Some(1e9));
    }

    #[test]
    fn no_durations_have_no_quantile_and_a_zero_duration_counts() {
        assert_eq!(Durations::default().quantile(0.5), None);
        let mut durations = Durations::default();
        durations.add(0);
        assert_eq!(
            (durations.quantile(0.5), durations.mean()),
            (Some(0.0), Some(0.0))
        );
    }
}
