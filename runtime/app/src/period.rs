//! The range of periods, which is the same for application files, operators, tools and fathers; and the
//! formats in which times are shown and typed. A typed period without a unit is an error: no unit is guessed.

use jde_core::Nanos;

/// The shortest period: the resolution that timers of a machine can keep.
pub const SHORTEST: Nanos = 100_000;
/// The longest period: no cycle of a robot takes a day, so a longer one is a mistaken unit.
pub const LONGEST: Nanos = 86_400_000_000_000;
/// The range, for messages.
pub const RANGE: &str = "from 100 us to a day";

/// How many times longer or shorter than the usual period a period probably has the wrong unit.
const WRONG_UNIT_FACTOR: Nanos = 100;

/// A period outside the range.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error("a period of {seconds} s is {}; give one {RANGE}", problem(*seconds))]
pub struct OutOfRange {
    /// The requested period, s.
    pub seconds: f64,
}

/// Converts a period in seconds to ns.
///
/// # Errors
/// [`OutOfRange`]
pub fn from_seconds(seconds: f64) -> Result<Nanos, OutOfRange> {
    // The cast saturates, so NaN and numbers that are too large are out of range.
    check((seconds * 1e9).round() as Nanos).map_err(|_| OutOfRange { seconds })
}

/// Returns the period if it is in range.
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

/// Whether a period is so much longer than another that one of them probably has the wrong unit.
#[must_use]
pub fn is_far_longer(one: Nanos, other: Nanos) -> bool {
    one / WRONG_UNIT_FACTOR >= other
}

/// The units in which a period may be typed, in ns.
const UNITS: [(&str, f64); 7] = [
    ("ns", 1.0),
    ("us", 1e3),
    ("µs", 1e3),
    ("ms", 1e6),
    ("s", 1e9),
    ("min", 60e9),
    ("h", 3600e9),
];

/// Parses a typed period: a number with ns, us, ms, s, min, h or Hz.
///
/// # Errors
/// A message for the user if there is no number, no unit, or if the period is out of [`RANGE`].
pub fn parse(typed: &str) -> Result<Nanos, String> {
    let typed = typed.trim();
    let end = typed
        .find(|letter: char| !letter.is_ascii_digit() && letter != '.')
        .unwrap_or(typed.len());
    let (number, unit) = (&typed[..end], typed[end..].trim());
    let number: f64 = number
        .parse()
        .map_err(|_| format!("“{typed}” is not a period: write 75ms, 0.5s or 20Hz"))?;
    let nanos = if unit.eq_ignore_ascii_case("hz") {
        1e9 / number
    } else {
        let known = UNITS.iter().find(|(name, _)| *name == unit);
        let (_, size) = known.ok_or_else(|| {
            format!("“{typed}” needs a unit, ns, us, ms, s, min, h or Hz: write 75ms or 20Hz")
        })?;
        number * size
    };
    // The cast saturates, so NaN and numbers that are too large are out of range.
    check(nanos.round() as Nanos).map_err(|_| format!("“{typed}” is out of range: a period is {RANGE}"))
}

/// Formats a time in its own unit with three significant digits: "75.0 ms".
#[must_use]
pub fn format_duration(nanos: Nanos) -> String {
    let (value, unit) = scaled(nanos);
    match value {
        _ if unit == "ns" => format!("{value:.0} {unit}"),
        value if value < 9.995 => format!("{value:.2} {unit}"),
        value if value < 99.95 => format!("{value:.1} {unit}"),
        _ => format!("{value:.0} {unit}"),
    }
}

/// Formats a configured time with no more digits than it needs: "75 ms", "82.5 ms".
#[must_use]
pub fn format_setting(nanos: Nanos) -> String {
    let (value, unit) = scaled(nanos);
    let digits = format!("{value:.3}");
    format!("{} {unit}", digits.trim_end_matches('0').trim_end_matches('.'))
}

fn scaled(nanos: Nanos) -> (f64, &'static str) {
    let value = nanos as f64;
    match nanos {
        0..1_000 => (value, "ns"),
        // A value that would be rounded up to 1000 of a unit is shown in the next unit.
        1_000..999_500 => (value / 1e3, "µs"),
        999_500..999_500_000 => (value / 1e6, "ms"),
        999_500_000.. => (value / 1e9, "s"),
    }
}

/// Describes what is wrong with a time out of range.
pub(crate) fn problem(seconds: f64) -> &'static str {
    if seconds * 1e9 > LONGEST as f64 {
        "longer than a day"
    } else if seconds > 0.0 {
        "shorter than 100 us"
    } else {
        "not a time above 0"
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_period_is_from_a_tenth_of_a_millisecond_to_a_day() {
        assert_eq!(from_seconds(100e-6), Ok(SHORTEST));
        assert_eq!(from_seconds(86_400.0), Ok(LONGEST));
        assert_eq!(check(75_000_000), Ok(75_000_000));
        let refused = |seconds: f64| from_seconds(seconds).unwrap_err().to_string();
        let year = "a period of 31557600 s is longer than a day; give one from 100 us to a day";
        assert_eq!(refused(31_557_600.0), year);
        assert!(refused(99e-6).contains("shorter than 100 us"));
        assert!(refused(-1.0).contains("not a time above 0") && refused(f64::NAN).contains("not a time"));
        assert!(refused(f64::INFINITY).contains("longer"));
        assert!(check(0).is_err() && check(LONGEST + 1).is_err());
    }

    #[test]
    fn a_duration_has_three_digits_and_its_own_unit() {
        let durations = [
            0,
            850,
            12_340,
            999_499,
            999_600,
            75_020_000,
            999_700_000,
            61_000_000_000,
        ];
        let texts = [
            "0 ns", "850 ns", "12.3 µs", "999 µs", "1.00 ms", "75.0 ms", "1.00 s", "61.0 s",
        ];
        assert_eq!(durations.map(format_duration), texts);
    }

    #[test]
    fn a_setting_is_formatted_without_trailing_zeros() {
        assert_eq!(
            [75_000_000, 82_500_000, 1_500_000_000].map(format_setting),
            ["75 ms", "82.5 ms", "1.5 s"]
        );
    }

    #[test]
    fn a_period_is_parsed_in_every_unit() {
        let typed = ["75ms", " 0.5 s ", "20Hz", "20 hz", "300us", "300µs", "5000000ns"];
        let nanos = [
            75_000_000,
            500_000_000,
            50_000_000,
            50_000_000,
            300_000,
            300_000,
            5_000_000,
        ];
        assert_eq!(typed.map(|typed| parse(typed).unwrap()), nanos);
    }

    #[test]
    fn a_period_without_a_number_or_unit_or_out_of_range_is_refused() {
        assert!(parse("").unwrap_err().contains("is not a period"));
        assert!(parse("fast").unwrap_err().contains("is not a period"));
        assert!(parse("1.2.3ms").unwrap_err().contains("is not a period"));
        assert!(parse("75").unwrap_err().contains("needs a unit"));
        assert!(parse("75 parsec").unwrap_err().contains("needs a unit"));
        for typed in ["0ms", "0Hz", "99us", "2000000s", "8766h"] {
            assert!(parse(typed).unwrap_err().contains("out of range"), "{typed}");
        }
    }
}
