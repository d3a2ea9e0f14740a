//! Axes: their numbers, and the format of times and numbers.

use jde_drawing::round_up;
use jde_drawing::{Align, ColorRole, Drawing, LineStyle};

use super::{Area, SMALL};
use crate::analysis::Columns;

/// Least distance between two grid lines, units.
const MIN_DISTANCE: f32 = 90.0;
/// Steps of minutes and hours, s.
const LONG_STEPS: [f64; 12] = [
    60.0, 120.0, 300.0, 600.0, 1200.0, 1800.0, 3600.0, 7200.0, 14_400.0, 21_600.0, 43_200.0, 86_400.0,
];

/// The times of the grid lines, s, with their labels.
fn times(columns: Columns, width: f32) -> Vec<(f64, String)> {
    let least = columns.seconds() * f64::from((MIN_DISTANCE / width).min(1.0));
    let long = LONG_STEPS.into_iter().find(|step| *step >= least);
    let step = match long {
        Some(step) if least > 50.0 => step,
        _ => round_up(least),
    };
    let (from, to) = (columns.from as f64 / 1e9, columns.to as f64 / 1e9);
    let first = (from / step).ceil() as i64;
    let last = (to / step).floor() as i64;
    let (scale, unit) = match step {
        step if step < 60.0 => (1.0, "s"),
        step if step < 3600.0 => (60.0, "min"),
        _ => (3600.0, "h"),
    };
    let digits = digits(step / scale);
    let mut times: Vec<_> = (first..=last)
        .map(|line| {
            let time = line as f64 * step;
            (time, format!("{:.digits$}", time / scale + 0.0))
        })
        .collect();
    if let Some((_, text)) = times.last_mut() {
        *text += " ";
        *text += unit;
    }
    times
}

/// Draws the grid lines of the times.
pub(crate) fn time_grid(drawing: &mut Drawing, area: Area, columns: Columns) {
    for (time, _) in times(columns, area.width) {
        let x = at(area, columns, time);
        drawing.polyline(
            &[(x, area.top), (x, area.bottom())],
            LineStyle::new(ColorRole::Grid, 1.0),
        );
    }
}

/// Draws the times below an area.
pub(crate) fn time_axis(drawing: &mut Drawing, area: Area, columns: Columns) {
    let times = times(columns, area.width);
    for (time, text) in times {
        let x = at(area, columns, time);
        drawing.label(
            &text,
            SMALL,
            (x, area.bottom() + 15.0),
            Align::Middle,
            ColorRole::Soft,
        );
    }
}

fn at(area: Area, columns: Columns, time: f64) -> f32 {
    let share = columns.place((time * 1e9).round() as u64) / columns.count as f64;
    // The middle of a unit, where a line has sharp edges.
    (area.left + area.width * share as f32).floor() + 0.5
}

/// Decimal places that a step needs.
fn digits(step: f64) -> usize {
    // Floating-point errors may leave a value slightly below 1, 0.1 and so on.
    (-(step * 1.000_001).log10().floor()).clamp(0.0, 12.0) as usize
}

/// The numbers on an axis of `length` units between `least` and `greatest`, with their labels.
pub(crate) fn numbers(least: f64, greatest: f64, length: f32) -> Vec<(f64, String)> {
    let max_count = (length / 34.0).clamp(1.0, 8.0);
    let step = round_up((greatest - least) / f64::from(max_count));
    let first = (least / step).ceil() as i64;
    let last = (greatest / step).floor() as i64;
    let digits = digits(step);
    // At most as many as fit, even if rounding errors of nearly equal bounds give more.
    (first..=last)
        .take(20)
        .map(|line| {
            let value = line as f64 * step;
            let text = if value.abs() >= 1e6 || (step < 1e-6 && value != 0.0) {
                format!("{value:.1e}")
            } else {
                format!("{:.digits$}", value + 0.0)
            };
            (value, text)
        })
        .collect()
}

/// A number with its useful digits.
pub(crate) fn number(value: f64) -> String {
    let digits = match value.abs() {
        size if size >= 1e7 || (size > 0.0 && size < 1e-4) => return format!("{value:.2e}"),
        size if size >= 1000.0 => 0,
        size if size >= 10.0 => 1,
        size if size >= 0.1 => 3,
        _ => 4,
    };
    let text = format!("{value:.digits$}");
    if text.contains('.') {
        text.trim_end_matches('0').trim_end_matches('.').to_owned()
    } else {
        text
    }
}

/// A time in seconds, in a suitable unit: "400 µs", "15.3 ms", "2.5 s", "3 min 20 s", "2 h 5 min".
pub(crate) fn seconds(time: f64) -> String {
    let rounded = time.round() as u64;
    match time {
        time if time < 0.999_5e-3 => format!("{} µs", three_digits(time * 1e6)),
        time if time < 0.999_5 => format!("{} ms", three_digits(time * 1e3)),
        time if time < 119.95 => format!("{} s", three_digits(time)),
        time if time < 3599.5 => format!("{} min {} s", rounded / 60, rounded % 60),
        _ => format!("{} h {} min", rounded / 3600, rounded % 3600 / 60),
    }
}

/// Three digits, or all before the decimal point.
fn three_digits(value: f64) -> String {
    let digits = match value.abs() {
        size if size >= 99.95 => 0,
        size if size >= 9.995 => 1,
        _ => 2,
    };
    let text = format!("{value:.digits$}");
    match text.split_once('.') {
        Some((whole, part)) if part.bytes().all(|digit| digit == b'0') => whole.to_owned(),
        _ => text,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn grid_lines_are_at_round_times_with_a_minimum_distance() {
        let texts = |seconds: u64, width| {
            let columns = Columns::new(0, seconds * 1_000_000_000, 100);
            let times = times(columns, width);
            times.into_iter().map(|(_, text)| text).collect::<Vec<_>>()
        };
        assert_eq!(texts(10, 500.0), ["0", "2", "4", "6", "8", "10 s"]);
        assert_eq!(texts(1, 500.0), ["0.0", "0.2", "0.4", "0.6", "0.8", "1.0 s"]);
        assert_eq!(texts(172, 500.0), ["0", "50", "100", "150 s"]);
        assert_eq!(texts(3600, 400.0), ["0", "20", "40", "60 min"]);
        assert_eq!(texts(30_000, 500.0), ["0", "2", "4", "6", "8 h"]);
    }

    #[test]
    fn axis_numbers_are_round() {
        let texts = |least, greatest| {
            let numbers = numbers(least, greatest, 150.0);
            numbers.into_iter().map(|(_, text)| text).collect::<Vec<_>>()
        };
        assert_eq!(texts(-0.12, 0.31), ["-0.1", "0.0", "0.1", "0.2", "0.3"]);
        assert_eq!(texts(0.0, 1.0), ["0.0", "0.5", "1.0"]);
        assert_eq!(texts(0.0, 43.0), ["0", "10", "20", "30", "40"]);
        assert!(texts(1e15, 1e15 + 1.0).len() <= 20);
    }

    #[test]
    fn times_and_numbers_have_suitable_units_and_digits() {
        let times = [0.000_4, 0.015_32, 0.1, 2.5, 200.0, 7500.0].map(seconds);
        assert_eq!(
            times,
            ["400 µs", "15.3 ms", "100 ms", "2.50 s", "3 min 20 s", "2 h 5 min"]
        );
        assert_eq!(
            [0.25, 12.0, 12.34, 0.001, 12345.6, -3.0, 1e9].map(number),
            ["0.25", "12", "12.3", "0.001", "12346", "-3", "1.00e9"]
        );
    }
}
