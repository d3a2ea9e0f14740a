//! Parses times, speeds and sizes of a command line.

use jde_core::Nanos;
use jde_recorder::PartSize;
use jde_report::{SIDES, Size};

/// Units of time with their nanoseconds.
const UNITS: [(&str, f64); 6] = [
    ("", 1e9),
    ("ms", 1e6),
    ("s", 1e9),
    ("min", 60e9),
    ("m", 60e9),
    ("h", 3600e9),
];
/// Units of size with their bytes.
const SIZES: [(&str, f64); 3] = [("kB", 1e3), ("MB", 1e6), ("GB", 1e9)];
/// The least and most memory of a size, in bytes.
const MIN_SIZE: f64 = 100e3;
const MAX_SIZE: f64 = 1e12;
/// The least size of one file of a recording in parts, in bytes and in ns: a few chunks, or the data of two
/// flushes.
const MIN_PART_BYTES: u64 = 1_000_000;
const MIN_PART_TIME: Nanos = 1_000_000_000;
/// A second and a day, ns.
const SECOND: Nanos = 1_000_000_000;
const DAY: Nanos = 86_400 * SECOND;
/// The longest time in s: a year.
const MAX_TIME_S: f64 = 366.0 * 86_400.0;

/// Parses a duration in ns, greater than 0: "60s", "2min", "500ms", or a number of seconds.
pub(crate) fn time(text: &str) -> Result<Nanos, String> {
    match time_offset(text)? {
        0 => Err(format!("`{text}` must be more than 0 and at most a year")),
        time => Ok(time),
    }
}

/// Parses a time in ns since the application's start, in the same form. "0s" is valid.
pub(crate) fn time_offset(text: &str) -> Result<Nanos, String> {
    let wrong = || format!("`{text}` is not a time; write a number with ms, s, min or h, such as 60s");
    let time = with_unit(text, &UNITS).ok_or_else(wrong)?;
    if (0.0..=MAX_TIME_S * 1e9).contains(&time) {
        Ok(time.round() as Nanos)
    } else {
        Err(format!("`{text}` must be 0 or more and at most a year"))
    }
}

/// Whether a text has the form of a time, which may be out of range.
pub(crate) fn is_time(text: &str) -> bool {
    with_unit(text, &UNITS).is_some()
}

/// Parses a time of a run that started at `start_ns`, ns since 1970, in ns since that start: a time as for
/// [`time_offset`], or a time of day in UTC, "19:06Z" or "19:06:45Z", which is the first one after the start.
pub(crate) fn moment(text: &str, start_ns: u64) -> Result<Nanos, String> {
    match clock(text) {
        None => time_offset(text),
        Some((_, false)) => Err(format!(
            "`{text}` states no time zone; write {text}Z for a time of day in UTC, as `jde info` shows the start"
        )),
        Some((of_day, true)) => {
            let since = (of_day + DAY - start_ns % DAY) % DAY;
            // The start is shown in whole seconds, so its own time of day may be a little before it.
            Ok(if since > DAY - SECOND { 0 } else { since })
        }
    }
}

/// Whether a text is a time of day, with its time zone or without.
pub(crate) fn is_time_of_day(text: &str) -> bool {
    clock(text).is_some()
}

/// Parses a time of day, in ns since midnight, and returns whether it is in UTC; `None` for a text of another form.
fn clock(text: &str) -> Option<(Nanos, bool)> {
    let digits = text.strip_suffix(['Z', 'z']);
    let mut parts = digits.unwrap_or(text).split(':');
    let below = |part: &str, end: f64| {
        let is_plain = part.starts_with(|letter: char| letter.is_ascii_digit());
        let number = part.parse::<f64>().ok().filter(|_| is_plain)?;
        (number < end).then_some(number)
    };
    let hours = below(parts.next()?, 24.0).filter(|hours| hours.fract() == 0.0)?;
    let minutes = below(parts.next()?, 60.0).filter(|minutes| minutes.fract() == 0.0)?;
    let seconds = parts.next().map_or(Some(0.0), |part| below(part, 60.0))?;
    if parts.next().is_some() {
        return None;
    }
    let of_day = (hours * 3600.0 + minutes * 60.0 + seconds) * 1e9;
    Some((of_day.round() as Nanos, digits.is_some()))
}

/// Parses a rate in 1/s: "5", "5Hz" or "0.5".
pub(crate) fn rate(text: &str) -> Result<f64, String> {
    let number = text.trim_end_matches("Hz").trim_end_matches("hz").trim();
    match number.parse::<f64>() {
        Ok(hz) if hz > 0.0 && hz.is_finite() => Ok(hz),
        Ok(_) | Err(_) => Err(format!(
            "`{text}` is not a rate; write a number per second, such as 2 or 0.5"
        )),
    }
}

/// Parses a size in bytes: "256MB", "1GB" or "64 kB".
pub(crate) fn size(text: &str) -> Result<usize, String> {
    let wrong = || format!("`{text}` is not a size; write a number with kB, MB or GB, such as 256MB");
    let size = with_unit(text, &SIZES).ok_or_else(wrong)?;
    if (MIN_SIZE..=MAX_SIZE).contains(&size) {
        Ok(size as usize)
    } else {
        Err(format!("`{text}` must be from 100 kB to 1000 GB"))
    }
}

/// Parses the size or duration of one file of a recording in parts: "1GB" or "10min".
pub(crate) fn part_limit(text: &str) -> Result<PartSize, String> {
    if text.ends_with('B') {
        let bytes = size(text)? as u64;
        return match bytes {
            MIN_PART_BYTES.. => Ok(PartSize::Bytes(bytes)),
            _ => Err(format!("`{text}` is too small for a file; give 1 MB or more")),
        };
    }
    let time = time(text)
        .map_err(|_| format!("`{text}` is neither a size nor a time; write one such as 1GB or 10min"))?;
    if time < MIN_PART_TIME {
        return Err(format!("`{text}` is too short for a file; give 1 s or more"));
    }
    Ok(PartSize::Time(time))
}

/// Parses the size of a picture in pixels: "1200x800".
pub(crate) fn pixels(text: &str) -> Result<Size, String> {
    let (least, most) = (SIDES.start(), SIDES.end());
    let wrong = || {
        format!(
            "`{text}` is not a size; write width and height, such as 1200x800, from {least} to {most} pixels each"
        )
    };
    let (width, height) = text.split_once(['x', 'X', '×']).ok_or_else(wrong)?;
    let side = |text: &str| text.trim().parse().ok().filter(|side| SIDES.contains(side));
    Ok(Size {
        width: side(width).ok_or_else(wrong)?,
        height: side(height).ok_or_else(wrong)?,
    })
}

/// Parses a number and its unit, and multiplies them.
fn with_unit(text: &str, units: &[(&str, f64)]) -> Option<f64> {
    let digits = text.find(|c: char| c.is_ascii_alphabetic()).unwrap_or(text.len());
    let (number, unit) = text.split_at(digits);
    let (_, size) = units.iter().find(|(name, _)| *name == unit)?;
    Some(number.trim().parse::<f64>().ok()? * size)
}

#[cfg(test)]
mod tests {
    use super::{
        DAY, PartSize, SECOND, Size, is_time_of_day, moment, part_limit, pixels, rate, size, time,
        time_offset,
    };

    #[test]
    fn the_size_of_a_picture_has_width_and_height() {
        let picture = |width, height| Ok(Size { width, height });
        assert_eq!(pixels("1200x800"), picture(1200, 800));
        assert_eq!(pixels("8000 × 200"), picture(8000, 200));
        for text in [
            "",
            "1200",
            "x",
            "1200x",
            "0x800",
            "199x800",
            "1200x8001",
            "-1x2",
            "1e3x900",
        ] {
            assert!(pixels(text).is_err(), "{text}");
        }
    }

    #[test]
    fn sizes_have_units() {
        assert_eq!(size("256MB"), Ok(256_000_000));
        assert_eq!(size("0.5 GB"), Ok(500_000_000));
        assert_eq!(size("100kB"), Ok(100_000));
        for text in ["", "256", "MB", "99kB", "-1MB", "nanMB", "1e9GB", "5 s"] {
            assert!(size(text).is_err(), "{text}");
        }
    }

    #[test]
    fn the_limit_of_a_part_is_a_size_or_a_time() {
        assert_eq!(part_limit("1GB"), Ok(PartSize::Bytes(1_000_000_000)));
        assert_eq!(part_limit("10min"), Ok(PartSize::Time(600_000_000_000)));
        for text in [
            "",
            "GB",
            "0GB",
            "999kB",
            "0",
            "0.5s",
            "-1min",
            "5 parsecs",
            "nan",
            "2 files",
        ] {
            assert!(part_limit(text).is_err(), "{text}");
        }
    }

    #[test]
    fn times_have_units_and_bare_numbers_are_seconds() {
        assert_eq!(time("60s"), Ok(60_000_000_000));
        assert_eq!(time("1.5"), Ok(1_500_000_000));
        assert_eq!(time("500ms"), Ok(500_000_000));
        assert_eq!(time("2min"), Ok(120_000_000_000));
        assert_eq!(time("1 h"), Ok(3_600_000_000_000));
    }

    #[test]
    fn invalid_times_are_refused() {
        for text in ["", "s", "ten", "5 parsecs", "0s", "-3s", "nan", "inf", "1e300h"] {
            assert!(time(text).is_err(), "{text}");
        }
    }

    #[test]
    fn a_time_offset_may_be_0() {
        assert_eq!(time_offset("0"), Ok(0));
        assert_eq!(time_offset("0s"), Ok(0));
        assert_eq!(time_offset("1.5s"), time("1.5s"));
        for text in ["-1s", "nan", "400000h", "s"] {
            assert!(time_offset(text).is_err(), "{text}");
        }
    }

    #[test]
    fn a_time_of_day_is_the_first_after_the_start() {
        // 19:06:40.5 of some day.
        let start = 20_000 * DAY + (19 * 3600 + 6 * 60 + 40) * SECOND + SECOND / 2;
        assert_eq!(moment("12.5s", start), Ok(12 * SECOND + SECOND / 2));
        assert_eq!(moment("19:06:45Z", start), Ok(4 * SECOND + SECOND / 2));
        assert_eq!(moment("19:07z", start), Ok(19 * SECOND + SECOND / 2));
        assert_eq!(moment("19:06:40Z", start), Ok(0), "the shown start");
        assert_eq!(moment("00:00Z", 0), Ok(0));
        let zone = moment("19:06:45", start).unwrap_err();
        assert!(zone.contains("write 19:06:45Z"), "{zone}");
        for text in [
            "24:00",
            "9",
            "robot2:7447",
            "10.0.0.1:7447",
            "1:2:3:4",
            "12:60Z",
            "::1",
            "",
        ] {
            assert!(!is_time_of_day(text), "{text}");
        }
    }

    #[test]
    fn rates_are_positive_numbers_per_second() {
        assert_eq!(rate("5Hz"), Ok(5.0));
        assert_eq!(rate("0.5"), Ok(0.5));
        for text in ["", "Hz", "0", "-1", "nan", "inf"] {
            assert!(rate(text).is_err(), "{text}");
        }
    }
}
