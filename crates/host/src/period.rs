//! The periods that a schema may have: one range for application files, operators, tools and fathers.

use jde_core::Nanos;

/// Shortest: what the timers of a machine can keep.
pub const SHORTEST: Nanos = 100_000;
/// Longest: a day is beyond any cycle of a robot, so more is a slip of units.
pub const LONGEST: Nanos = 86_400_000_000_000;
/// The range in words.
pub const RANGE: &str = "from 100 us to a day";

/// A period that no schema may have.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error("a period of {seconds} s is {}; give one {RANGE}", problem(*seconds))]
pub struct OutOfRange {
    /// What was asked for, s.
    pub seconds: f64,
}

/// A period in seconds as a number of ns.
///
/// # Errors
/// [`OutOfRange`]
pub fn of_seconds(seconds: f64) -> Result<Nanos, OutOfRange> {
    // What is no number of ns saturates, and is out of range.
    check((seconds * 1e9).round() as Nanos).map_err(|_| OutOfRange { seconds })
}

/// A period, if it is one.
///
/// # Errors
/// [`OutOfRange`]
pub fn check(period: Nanos) -> Result<Nanos, OutOfRange> {
    if (SHORTEST..=LONGEST).contains(&period) {
        Ok(period)
    } else {
        let seconds = period as f64 / 1e9;
        Err(OutOfRange { seconds })
    }
}

/// What is wrong with a time out of range.
pub(crate) fn problem(seconds: f64) -> &'static str {
    if seconds * 1e9 > LONGEST as f64 {
        "longer than a day"
    } else if seconds > 0.0 {
        "shorter than 100 us"
    } else {
        "no time above 0"
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_period_is_from_a_tenth_of_a_millisecond_to_a_day() {
        assert_eq!(of_seconds(100e-6), Ok(SHORTEST));
        assert_eq!(of_seconds(86_400.0), Ok(LONGEST));
        assert_eq!(check(75_000_000), Ok(75_000_000));
        let refused = |seconds: f64| of_seconds(seconds).unwrap_err().to_string();
        let year = "a period of 31557600 s is longer than a day; give one from 100 us to a day";
        assert_eq!(refused(31_557_600.0), year);
        assert!(refused(99e-6).contains("shorter than 100 us"));
        assert!(refused(-1.0).contains("no time above 0") && refused(f64::NAN).contains("no time"));
        assert!(refused(f64::INFINITY).contains("longer"));
        assert!(check(0).is_err() && check(LONGEST + 1).is_err());
    }
}
