//! Times in words, and a typed period as a time. Refuses to guess: a period without a unit is none.

/// The units in which a period may be typed, in s.
const UNITS: [(&str, f64); 5] = [("ns", 1e-9), ("us", 1e-6), ("µs", 1e-6), ("ms", 1e-3), ("s", 1.0)];
/// The shortest period that can be typed, s: waking a thread takes up to this long.
const SHORTEST_S: f64 = 100e-6;
/// The longest, s: a schema slower than once an hour is a slip of the fingers.
const LONGEST_S: f64 = 3600.0;

/// A time of s, in its own unit with three digits: "75.0 ms".
pub(crate) fn span(seconds: f64) -> String {
    let (value, unit) = scaled(seconds);
    match value.abs() {
        _ if unit == "ns" => format!("{value:.0} {unit}"),
        size if size < 9.995 => format!("{value:.2} {unit}"),
        size if size < 99.95 => format!("{value:.1} {unit}"),
        _ => format!("{value:.0} {unit}"),
    }
}

/// A time that somebody chose, with no more digits than it needs: "75 ms", "82.5 ms".
pub(crate) fn setting(seconds: f64) -> String {
    let (value, unit) = scaled(seconds);
    let digits = format!("{value:.3}");
    format!("{} {unit}", digits.trim_end_matches('0').trim_end_matches('.'))
}

/// Reads a period in s: a time with ns, us, ms or s, or a frequency with Hz.
///
/// # Errors
/// What is wrong and what could be written, in words for the person who typed it.
pub(crate) fn period(typed: &str) -> Result<f64, String> {
    let typed = typed.trim();
    let end = typed
        .find(|letter: char| !letter.is_ascii_digit() && letter != '.')
        .unwrap_or(typed.len());
    let (number, unit) = (&typed[..end], typed[end..].trim());
    let number: f64 = number
        .parse()
        .map_err(|_| format!("“{typed}” is no period: write 75ms, 0.5s or 20Hz"))?;
    let seconds = if unit.eq_ignore_ascii_case("hz") {
        1.0 / number
    } else {
        let (_, size) = UNITS
            .iter()
            .find(|(name, _)| *name == unit)
            .ok_or_else(|| format!("“{typed}” has no unit of time: write 75ms, 0.5s or 20Hz"))?;
        number * size
    };
    // As the application keeps it, in whole ns.
    let seconds = (seconds * 1e9).round() / 1e9;
    if !(SHORTEST_S..=LONGEST_S).contains(&seconds) {
        return Err(format!(
            "“{typed}” is out of range: a period lies between 100us and one hour"
        ));
    }
    Ok(seconds)
}

fn scaled(seconds: f64) -> (f64, &'static str) {
    match seconds.abs() {
        0.0 => (0.0, "s"),
        // What would be rounded up to 1000 of a unit is told in the next.
        size if size < 0.9995e-6 => (seconds * 1e9, "ns"),
        size if size < 0.9995e-3 => (seconds * 1e6, "µs"),
        size if size < 0.9995 => (seconds * 1e3, "ms"),
        _ => (seconds, "s"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_time_has_its_own_unit_and_three_digits() {
        let times = [0.0, 8.5e-7, 12.34e-6, 0.99949e-3, 0.9996e-3, 0.07502, -0.4, 61.0];
        let words = [
            "0.00 s", "850 ns", "12.3 µs", "999 µs", "1.00 ms", "75.0 ms", "-400 ms", "61.0 s",
        ];
        assert_eq!(times.map(span), words);
        assert_eq!([0.075, 0.0825, 1.5].map(setting), ["75 ms", "82.5 ms", "1.5 s"]);
    }

    #[test]
    fn a_period_is_read_in_every_unit_and_refused_in_words() {
        for typed in ["50ms", " 0.05 s ", "20Hz", "20 hz", "50000us", "50000µs"] {
            assert_eq!(period(typed), Ok(0.05), "{typed}");
        }
        for (typed, reason) in [
            ("", "is no period"),
            ("fast", "is no period"),
            ("1.2.3ms", "is no period"),
            ("75", "has no unit"),
            ("75 parsec", "has no unit"),
            ("0Hz", "out of range"),
            ("2h", "has no unit"),
            ("4000s", "out of range"),
            ("10us", "out of range"),
        ] {
            assert!(period(typed).unwrap_err().contains(reason), "{typed}");
        }
    }
}
