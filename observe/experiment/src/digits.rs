//! The digits of numbers: as many as an interval makes significant, the same for all rows of a table.
//!
//! It adds no units.

use crate::statistics::Interval;

/// Least number of last digits that fit into an interval: `[0.29, 0.33]`, and not `[0.3, 0.3]`.
const MIN_LAST_DIGITS: f64 = 3.0;
/// What is significant of a number without an interval: a hundredth of it.
const SIGNIFICANT_PARTS: f64 = 100.0;
/// Relative errors of sums and differences are smaller.
const ROUNDING_ERROR: f64 = 1e-9;
/// Most decimal places; the steps of measures are rarely finer.
const MAX_DECIMALS: usize = 6;
/// Numbers from here on are written with an exponent.
const EXPONENT_FROM: f64 = 1e7;
/// Numbers up to here are written with an exponent, if all of them are so small.
const EXPONENT_BELOW: f64 = 1e-4;

/// The way to write the numbers of one measure.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Digits {
    /// With this number of decimal places.
    Decimals(usize),
    /// With an exponent.
    Exponent,
}

impl Digits {
    /// Chooses the digits for medians with their intervals: the narrowest interval counts.
    #[must_use]
    pub fn of(medians: impl IntoIterator<Item = (f64, Interval)>) -> Self {
        let (mut width, mut least, mut greatest, mut whole) = (f64::MAX, f64::MAX, 0.0f64, true);
        for (median, Interval { low, high }) in medians {
            // A difference of equal values is not exactly 0.
            if high - low > ROUNDING_ERROR * high.abs().max(low.abs()) {
                width = width.min(high - low);
            }
            for size in [median, low, high].map(f64::abs) {
                greatest = greatest.max(size);
                whole &= size.fract() == 0.0;
                if size > 0.0 {
                    least = least.min(size);
                }
            }
        }
        match greatest {
            greatest if greatest >= EXPONENT_FROM || (greatest > 0.0 && greatest <= EXPONENT_BELOW) => {
                Self::Exponent
            }
            _ if whole => Self::Decimals(0),
            _ if width < f64::MAX => Self::Decimals(decimals(width / MIN_LAST_DIGITS)),
            _ => Self::Decimals(decimals(least / SIGNIFICANT_PARTS)),
        }
    }

    /// Writes a number.
    #[must_use]
    pub fn text(self, value: f64) -> String {
        let text = match self {
            Self::Decimals(decimals) => format!("{value:.decimals$}"),
            Self::Exponent => format!("{value:.2e}"),
        };
        // A small negative number is not "-0.0".
        match text.strip_prefix('-') {
            Some(size) if !size.contains(|digit| matches!(digit, '1'..='9')) => size.to_owned(),
            _ => text,
        }
    }

    /// Writes a difference: with its sign, unless it is 0.
    #[must_use]
    pub fn signed(self, value: f64) -> String {
        let text = self.text(value);
        let is_positive = value > 0.0 && text.contains(|digit| matches!(digit, '1'..='9'));
        if is_positive { format!("+{text}") } else { text }
    }
}

/// The decimal places of a step. Counted, since logarithms differ between platforms.
fn decimals(step: f64) -> usize {
    (0..MAX_DECIMALS)
        .find(|decimals| step * 10f64.powi(*decimals as i32) >= 1.0 - ROUNDING_ERROR)
        .unwrap_or(MAX_DECIMALS)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn digits(median: f64, low: f64, high: f64) -> Digits {
        Digits::of([(median, Interval { low, high })])
    }

    #[test]
    fn the_digits_are_those_that_the_interval_makes_significant() {
        let texts = |median, low, high| {
            let digits = digits(median, low, high);
            [median, low, high].map(|value| digits.text(value))
        };
        assert_eq!(texts(0.312_34, 0.29, 0.331), ["0.31", "0.29", "0.33"]);
        assert_eq!(texts(112.34, 108.2, 117.9), ["112", "108", "118"]);
        assert_eq!(texts(41.234, 40.4, 42.1), ["41.2", "40.4", "42.1"]);
        assert_eq!(texts(3.0, 2.0, 4.0), ["3", "2", "4"]);
        assert_eq!(texts(0.5, 0.5, 0.5), ["0.500", "0.500", "0.500"]);
        assert_eq!(texts(2e9, 1e9, 3e9), ["2.00e9", "1.00e9", "3.00e9"]);
        assert_eq!(texts(2e-5, 1e-5, 3e-5), ["2.00e-5", "1.00e-5", "3.00e-5"]);
        assert_eq!(texts(0.0, 0.0, 0.0), ["0", "0", "0"]);
        let almost = 0.3 - 0.2;
        assert_eq!(texts(almost, almost, 0.1), ["0.100", "0.100", "0.100"]);
    }

    #[test]
    fn the_narrowest_interval_counts_for_all_rows() {
        let wide = Interval { low: 1.0, high: 9.5 };
        let narrow = Interval {
            low: 5.49,
            high: 5.53,
        };
        let empty = Interval { low: 5.5, high: 5.5 };
        assert_eq!(
            Digits::of([(5.0, wide), (5.5, narrow), (5.5, empty)]),
            Digits::Decimals(2)
        );
    }

    #[test]
    fn a_difference_has_its_sign_and_zero_none() {
        let digits = Digits::Decimals(1);
        assert_eq!(
            [0.26, -0.26, 0.04, -0.04, 0.0].map(|value| digits.signed(value)),
            ["+0.3", "-0.3", "0.0", "0.0", "0.0"]
        );
    }
}
