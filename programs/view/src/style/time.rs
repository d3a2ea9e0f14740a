//! Formats and parses times in s. The notation is that of [`jde_app::period`], which all tools share.

use jde_app::period;
use jde_core::Nanos;

/// Formats a time in s in a suitable unit with three digits: "75.0 ms".
pub(crate) fn span(seconds: f64) -> String {
    let sign = if seconds < 0.0 { "-" } else { "" };
    format!("{sign}{}", period::format_duration(nanos(seconds.abs())))
}

/// Formats a time that a user set, with no more digits than it needs: "75 ms", "82.5 ms".
pub(crate) fn setting(seconds: f64) -> String {
    period::format_setting(nanos(seconds))
}

/// Parses a period. Returns s.
///
/// # Errors
/// What is wrong and what is accepted, as a message for the user.
pub(crate) fn period(typed: &str) -> Result<f64, String> {
    Ok(period::parse(typed)? as f64 / 1e9)
}

fn nanos(seconds: f64) -> Nanos {
    (seconds * 1e9).round() as Nanos
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_are_formatted_and_parsed_as_in_all_tools() {
        assert_eq!([0.07502, -0.4].map(span), ["75.0 ms", "-400 ms"]);
        assert_eq!(setting(0.0825), "82.5 ms");
        assert_eq!(period("20Hz"), Ok(0.05));
        assert_eq!(period("2h"), Ok(7200.0));
    }
}
