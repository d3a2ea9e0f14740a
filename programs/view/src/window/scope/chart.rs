//! The traces that share a picture: numbers over time, or one number against another. Numbers of one unit share an axis.

use eframe::egui::{Align2, Painter, Rect, Stroke, pos2, vec2};
use jde_link::message::VariableInfo;
use jde_panel::Ink;
use jde_timeline::range;

use super::axis::Scale;
use super::paint;
use super::signal::Signal;
use super::source::Source;
use crate::style::{self, Style};

/// The word between two numbers of which one is drawn against the other.
const AGAINST: &str = " against ";
/// Height of a chart over time, in points.
const HEIGHT: f32 = 58.0;
/// Height of a chart of one number against another, in points.
const SQUARE_HEIGHT: f32 = 200.0;
/// Height of a name with its value, in points.
pub(super) const LINE: f32 = 17.0;

/// Traces in one picture.
#[derive(Debug)]
pub(super) struct Chart {
    /// Its text, as typed: "a.b.c, a.b.d", or "a.b.y against a.b.x".
    pub(super) name: String,
    pub(super) signals: Vec<Signal>,
    /// Whether the first number is drawn against the second.
    is_against: bool,
}

impl Chart {
    /// Reads a text: names or expressions, with commas between them, or two with "against". `color` is the first color.
    ///
    /// # Errors
    /// Why one of them is no number.
    pub(super) fn parse(text: &str, variables: &[VariableInfo], color: usize) -> Result<Self, String> {
        let text = text.trim();
        let against = text.split_once(AGAINST);
        let parts = match against {
            Some((y, x)) => vec![y, x],
            None => split(text),
        };
        let signal = |(place, part): (usize, &str)| {
            let source = Source::parse(part.trim(), variables)?;
            Ok(Signal::new(part.trim().to_owned(), source, color + place))
        };
        let signals: Result<Vec<_>, String> = parts.into_iter().enumerate().map(signal).collect();
        Ok(Self {
            name: text.to_owned(),
            signals: signals?,
            is_against: against.is_some(),
        })
    }

    /// The height that it needs, in points.
    pub(super) fn height(&self) -> f32 {
        let least = if self.is_against { SQUARE_HEIGHT } else { HEIGHT };
        least.max(8.0 + LINE * self.signals.len() as f32)
    }

    /// Draws the traces until a time, in the visible part of the past.
    pub(super) fn draw(&self, painter: &Painter, rect: Rect, scale: &Scale, end: f64, style: &Style) {
        if let (true, [y, x]) = (self.is_against, self.signals.as_slice()) {
            return square(painter, rect, scale, (x, y), style);
        }
        let faint = style::color_of(Ink::Faint, style);
        let mut units: Vec<&str> = Vec::new();
        for signal in &self.signals {
            if !units.contains(&signal.unit()) {
                units.push(signal.unit());
            }
        }
        let mut is_empty = true;
        for (axis, unit) in units.into_iter().enumerate() {
            let of_unit = || self.signals.iter().filter(|signal| signal.unit() == unit);
            let values = of_unit().flat_map(|signal| signal.between(scale.from, scale.to));
            let Some((least, most)) = range(values.map(|(_, value)| value)) else {
                continue;
            };
            is_empty = false;
            for signal in of_unit() {
                signal.draw(painter, rect, scale, end, with_margin(least, most), style);
            }
            // There is room for the numbers of two axes.
            let (x, sides) = match axis {
                0 => (rect.left(), [Align2::LEFT_TOP, Align2::LEFT_BOTTOM]),
                1 => (rect.right(), [Align2::RIGHT_TOP, Align2::RIGHT_BOTTOM]),
                _ => continue,
            };
            for (value, y, side) in [(most, rect.top(), sides[0]), (least, rect.bottom(), sides[1])] {
                painter.text(
                    pos2(x, y),
                    side,
                    style.units.show(value, unit),
                    paint::small(),
                    faint,
                );
            }
        }
        if is_empty {
            paint::write(painter, rect.shrink(6.0), "no value yet", paint::small(), faint);
        }
    }
}

/// Draws one number against another, while both have values.
fn square(painter: &Painter, rect: Rect, scale: &Scale, (x, y): (&Signal, &Signal), style: &Style) {
    let faint = style::color_of(Ink::Faint, style);
    let times = x
        .between(scale.from, scale.to)
        .chain(y.between(scale.from, scale.to));
    let mut times: Vec<f64> = times.map(|(time, _)| time.max(scale.from)).collect();
    times.sort_by(f64::total_cmp);
    times.dedup();
    let points: Vec<_> = times.into_iter().map(|time| x.at(time).zip(y.at(time))).collect();
    let known = || points.iter().flatten();
    let ranges = range(known().map(|point| point.0)).zip(range(known().map(|point| point.1)));
    let Some((across, up)) = ranges else {
        paint::write(
            painter,
            rect.shrink(6.0),
            "no values of both yet",
            paint::small(),
            faint,
        );
        return;
    };
    let frame = Rect::from_min_max(rect.min + vec2(70.0, 2.0), rect.max - vec2(0.0, 18.0));
    let mut frame = frame.with_max_x(frame.right().min(frame.left() + 1.6 * frame.height()));
    let (mut wide, mut high) = (with_margin(across.0, across.1), with_margin(up.0, up.1));
    if x.unit() == y.unit() {
        // A circle is a circle.
        let per_point =
            ((wide.1 - wide.0) / f64::from(frame.width())).max((high.1 - high.0) / f64::from(frame.height()));
        let grow = |(least, most): (f64, f64), points: f32| {
            let (middle, half) = (f64::midpoint(least, most), per_point * f64::from(points) / 2.0);
            (middle - half, middle + half)
        };
        (wide, high) = (grow(wide, frame.width()), grow(high, frame.height()));
    }
    painter.rect_stroke(
        frame,
        0.0,
        Stroke::new(1.0, faint),
        eframe::egui::StrokeKind::Inside,
    );
    frame = frame.shrink(1.0);
    let place = |(across, up): (f64, f64)| {
        let share = |value: f64, (least, most): (f64, f64)| ((value - least) / (most - least)) as f32;
        pos2(
            frame.left() + share(across, wide) * frame.width(),
            frame.bottom() - share(up, high) * frame.height(),
        )
    };
    let stroke = Stroke::new(1.4, paint::signal_color(y.color, style));
    for piece in points.split(Option::is_none) {
        painter.line(piece.iter().flatten().copied().map(place).collect(), stroke);
    }
    for (at, align, signal, value) in [
        (frame.left_bottom() + vec2(0.0, 3.0), Align2::LEFT_TOP, x, wide.0),
        (
            frame.right_bottom() + vec2(0.0, 3.0),
            Align2::RIGHT_TOP,
            x,
            wide.1,
        ),
        (
            frame.left_bottom() - vec2(5.0, 0.0),
            Align2::RIGHT_BOTTOM,
            y,
            high.0,
        ),
        (frame.left_top() - vec2(5.0, 0.0), Align2::RIGHT_TOP, y, high.1),
    ] {
        painter.text(at, align, signal.show(value, style), paint::small(), faint);
    }
}

/// A range with a margin, also for a constant.
fn with_margin(least: f64, most: f64) -> (f64, f64) {
    let size = least.abs().max(most.abs());
    let margin = ((most - least) * 0.08).max(size * 1e-6).max(1e-9);
    (least - margin, most + margin)
}

/// Splits a text at its commas, except those within brackets.
fn split(text: &str) -> Vec<&str> {
    let mut depth = 0_i32;
    let at_comma = move |letter: char| {
        depth += i32::from(matches!(letter, '(' | '[' | '{')) - i32::from(matches!(letter, ')' | ']' | '}'));
        letter == ',' && depth == 0
    };
    text.split(at_comma)
        .filter(|part| !part.trim().is_empty())
        .collect()
}

/// The values of charts as a table of comma-separated values: a line for each time of a value, each value until its next.
pub(super) fn csv(charts: &[Chart], scale: &Scale) -> String {
    let signals: Vec<&Signal> = charts.iter().flat_map(|chart| &chart.signals).collect();
    let title = |signal: &&Signal| {
        let unit = match signal.unit() {
            "" => String::new(),
            unit => format!(" [{unit}]"),
        };
        format!("\"{}{unit}\"", signal.name.replace('"', "\"\""))
    };
    let titles: Vec<_> = signals.iter().map(title).collect();
    let mut text = format!("time_s,{}\n", titles.join(","));
    let times = signals
        .iter()
        .flat_map(|signal| signal.between(scale.from, scale.to));
    let mut times: Vec<f64> = times
        .map(|(time, _)| time)
        .filter(|time| *time >= scale.from)
        .collect();
    times.sort_by(f64::total_cmp);
    times.dedup();
    for time in times {
        let value = |signal: &&Signal| {
            signal
                .at(time)
                .map_or_else(String::new, |value| value.to_string())
        };
        let values: Vec<_> = signals.iter().map(value).collect();
        text += &format!("{time},{}\n", values.join(","));
    }
    text
}

#[cfg(test)]
mod tests {
    use eframe::egui::Rangef;
    use jde_ros::definition;
    use jde_types::{Twist, Value};

    use super::*;

    fn variables() -> [VariableInfo; 2] {
        let of = Twist::describe();
        ["robot.velocity", "robot.setpoint"].map(|name| VariableInfo {
            name: name.to_owned(),
            type_name: definition::name(&of),
            definition: definition::definition(&of),
            ..VariableInfo::default()
        })
    }

    fn take(chart: &mut Chart, time: f64, variable: &str, twist: Twist) {
        for signal in &mut chart.signals {
            signal.take(time, variable, Some(twist.as_bytes()));
        }
    }

    #[test]
    fn a_chart_has_fields_and_expressions_and_a_table_of_their_values() {
        let text =
            "robot.velocity.linear.x, math.greatest(robot.velocity.linear.x, robot.setpoint.linear.x) * 2.0";
        let mut chart = Chart::parse(text, &variables(), 0).expect("both are numbers");
        assert_eq!(chart.signals.len(), 2);
        take(&mut chart, 1.0, "robot.velocity", Twist::planar(0.5, 0.0));
        take(&mut chart, 2.0, "robot.setpoint", Twist::planar(0.75, 0.0));
        // It was measured before, and arrives after.
        take(&mut chart, 1.5, "robot.velocity", Twist::planar(1.0, 0.0));
        let scale = Scale {
            from: 0.0,
            to: 10.0,
            x: Rangef::new(0.0, 1.0),
        };
        let table = csv(&[chart], &scale);
        let lines: Vec<_> = table.lines().collect();
        assert!(
            lines[0].starts_with("time_s,\"robot.velocity.linear.x"),
            "{table}"
        );
        assert_eq!(&lines[1..], ["1,0.5,", "1.5,1,", "2,1,2"]);
    }

    #[test]
    fn what_is_no_number_is_refused_with_the_reason() {
        let error = |text: &str| Chart::parse(text, &variables(), 0).expect_err(text);
        assert!(error("robot.velocitty.linear.x").contains("did you mean `robot.velocity`?"));
        assert!(error("robot.velocity.linear.x, robot.velocity").contains("name one of its fields"));
        assert!(error("robot.velocity.linear.x * time").contains("`time` is none"));
        assert!(!error("robot.velocity.linear.x +").is_empty());
    }
}
