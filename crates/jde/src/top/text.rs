//! Durations, numbers and names as text of a stated width, and a typed period as a duration.
//!
//! It refuses to guess: a period without a unit is an error.

use jde_core::Nanos;
use jde_host::period::{RANGE, check};
use ratatui::text::Span;

const UNITS: [(&str, f64); 7] = [
    ("ns", 1.0),
    ("us", 1e3),
    ("µs", 1e3),
    ("ms", 1e6),
    ("s", 1e9),
    ("min", 60e9),
    ("h", 3600e9),
];

/// Gives a duration in its own unit with three significant digits: "75.0 ms".
pub(crate) fn span(nanos: Nanos) -> String {
    let (value, unit) = scaled(nanos);
    match value {
        _ if unit == "ns" => format!("{value:.0} {unit}"),
        v if v < 9.995 => format!("{value:.2} {unit}"),
        v if v < 99.95 => format!("{value:.1} {unit}"),
        _ => format!("{value:.0} {unit}"),
    }
}

/// Gives a duration that somebody chose, with no more digits than it needs: "75 ms", "82.5 ms".
pub(crate) fn setting(nanos: Nanos) -> String {
    let (value, unit) = scaled(nanos);
    let digits = format!("{value:.3}");
    format!("{} {unit}", digits.trim_end_matches('0').trim_end_matches('.'))
}

/// Gives a time since the start in seconds: "12.345 s".
pub(crate) fn moment(nanos: Nanos) -> String {
    format!("{:.3} s", nanos as f64 / 1e9)
}

/// Reads a period: a number with ns, us, ms, s, min, h or Hz.
///
/// Errors: no number, no unit, out of the range of periods; in words for the person who typed it.
pub(crate) fn period(typed: &str) -> Result<Nanos, String> {
    let typed = typed.trim();
    let split = typed
        .find(|c: char| !c.is_ascii_digit() && c != '.')
        .unwrap_or(typed.len());
    let (number, unit) = (&typed[..split], typed[split..].trim());
    let number: f64 = number
        .parse()
        .map_err(|_| format!("“{typed}” is not a period: write 75ms, 0.5s or 20Hz"))?;
    let nanos = if unit.eq_ignore_ascii_case("hz") {
        1e9 / number
    } else {
        let known = UNITS.iter().find(|(name, _)| *name == unit);
        number
            * known
                .ok_or_else(|| {
                    format!("“{typed}” needs a unit, ns, us, ms, s, min, h or Hz: write 75ms or 20Hz")
                })?
                .1
    };
    check(nanos.round() as Nanos).map_err(|_| format!("“{typed}” is out of range: a period is {RANGE}"))
}

/// Cuts or pads a text to a width in columns of the terminal.
pub(super) fn fit(text: &str, width: usize) -> String {
    let mut fitted = cut(text, width);
    fitted.extend(std::iter::repeat_n(' ', width - columns(&fitted)));
    fitted
}

/// Cuts a text to a width in columns of the terminal; what is lost is marked with an ellipsis.
pub(super) fn cut(text: &str, width: usize) -> String {
    if columns(text) <= width {
        return text.to_owned();
    }
    let mut kept = String::new();
    for letter in text.chars() {
        let longer = format!("{kept}{letter}");
        if columns(&longer) + 1 > width {
            break;
        }
        kept = longer;
    }
    if width > 0 {
        kept.push('…');
    }
    kept
}

/// Tells how many columns of the terminal a text takes.
pub(super) fn columns(text: &str) -> usize {
    Span::raw(text).width()
}

fn scaled(nanos: Nanos) -> (f64, &'static str) {
    let value = nanos as f64;
    match nanos {
        0..1_000 => (value, "ns"),
        // What would be rounded up to 1000 of a unit is told in the next.
        1_000..999_500 => (value / 1e3, "µs"),
        999_500..999_500_000 => (value / 1e6, "ms"),
        999_500_000.. => (value / 1e9, "s"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_span_has_three_digits_and_its_own_unit() {
        let spans = [
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
        assert_eq!(spans.map(span), texts);
    }

    #[test]
    fn a_setting_has_the_digits_it_needs() {
        assert_eq!(
            [75_000_000, 82_500_000, 1_500_000_000].map(setting),
            ["75 ms", "82.5 ms", "1.5 s"]
        );
    }

    #[test]
    fn a_period_is_read_in_every_unit() {
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
        assert_eq!(typed.map(|typed| period(typed).unwrap()), nanos);
    }

    #[test]
    fn a_period_that_says_too_little_is_refused_in_words() {
        assert!(period("").unwrap_err().contains("is not a period"));
        assert!(period("fast").unwrap_err().contains("is not a period"));
        assert!(period("1.2.3ms").unwrap_err().contains("is not a period"));
        assert!(period("75").unwrap_err().contains("needs a unit"));
        assert!(period("75 parsec").unwrap_err().contains("needs a unit"));
        for typed in ["0ms", "0Hz", "99us", "2000000s", "8766h"] {
            assert!(period(typed).unwrap_err().contains("out of range"), "{typed}");
        }
    }

    #[test]
    fn a_text_is_cut_and_padded_to_columns() {
        assert_eq!(fit("goon", 6), "goon  ");
        assert_eq!(fit("safe-navigation", 6), "safe-…");
        assert_eq!(fit("走行走行", 6), "走行… ");
        assert_eq!(fit("x", 0), "");
    }
}
