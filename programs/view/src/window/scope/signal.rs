//! A number over time: its values and its curve.

use std::sync::Arc;

use eframe::egui::{Painter, Pos2, Rect, Stroke, pos2};
use jde_timeline::Trace;

use super::axis::Scale;
use super::paint;
use super::source::Source;
use crate::style::Style;

/// Maximum number of values kept: 27 minutes at 50 Hz.
const MAX_VALUES: usize = 80_000;

/// A number over time.
#[derive(Debug)]
pub(super) struct Signal {
    /// The variable and the path in it, or the expression, as requested.
    pub(super) name: String,
    pub(super) source: Source,
    /// Index of the color.
    pub(super) color: usize,
    values: Trace,
    /// The last time of a value, s.
    last_s: Option<f64>,
    /// The values of a whole recording, once they have been read.
    pub(super) whole: Option<Arc<Trace>>,
}

impl Signal {
    pub(super) fn new(name: String, source: Source, color: usize) -> Self {
        Self {
            name,
            source,
            color,
            values: Trace::new(MAX_VALUES),
            last_s: None,
            whole: None,
        }
    }

    /// Takes a value of a variable at a time in s.
    pub(super) fn take(&mut self, time: f64, variable: &str, bytes: Option<&[u8]>) {
        let Some(value) = self.source.take(variable, bytes) else {
            return;
        };
        // Values of several variables do not arrive in the order of their times.
        let time = match (&self.source, self.last_s) {
            (Source::Expression(_), Some(last)) => time.max(last),
            (Source::Expression(_), None) | (Source::Field { .. }, _) => time,
        };
        self.values.add(time, value);
        self.last_s = Some(time);
    }

    /// Ends the curve: the next value belongs to another time.
    pub(super) fn interrupt(&mut self) {
        if let Some(last) = self.last_s.take() {
            // The last value is not known to hold for any time.
            self.values.add(last, f64::NAN);
        }
    }

    fn trace(&self) -> &Trace {
        self.whole.as_deref().unwrap_or(&self.values)
    }

    /// The value at a time: the last one written before it.
    pub(super) fn at(&self, time: f64) -> Option<f64> {
        self.trace().at(time)
    }

    /// The newest value; in a whole recording, that of the present.
    pub(super) fn present(&self, now: f64) -> Option<f64> {
        match &self.whole {
            Some(whole) => whole.at(now),
            None => self.values.at(f64::INFINITY),
        }
    }

    /// The values from the one in force at a time, s, until another time.
    pub(super) fn between(&self, from: f64, to: f64) -> impl Iterator<Item = (f64, f64)> {
        self.trace().between(from, to)
    }

    pub(super) fn unit(&self) -> &str {
        self.source.unit()
    }

    /// Formats a value in the user's units.
    pub(super) fn show(&self, value: f64, style: &Style) -> String {
        style.units.show(value, self.unit())
    }

    /// Draws the curve until a time, on an axis of values. Each value lasts until the next.
    pub(super) fn draw(
        &self,
        painter: &Painter,
        rect: Rect,
        scale: &Scale,
        end: f64,
        (bottom, top): (f64, f64),
        style: &Style,
    ) {
        let y = |value: f64| rect.bottom() - ((value - bottom) / (top - bottom)) as f32 * rect.height();
        let stroke = Stroke::new(1.4, paint::signal_color(self.color, style));
        let mut curve = Curve::default();
        for (time, value) in self.between(scale.from, scale.to) {
            let x = scale.x(time).max(rect.left());
            if value.is_finite() {
                curve.to(painter, x, y(value), stroke);
            } else {
                curve.end(painter, x, stroke);
            }
        }
        curve.end(painter, scale.x(end).min(rect.right()), stroke);
    }
}

/// A stepped line with at most four points per column of the screen.
#[derive(Default)]
struct Curve {
    points: Vec<Pos2>,
    /// The current column: its x, and the top and bottom y in it.
    column: Option<(f32, f32, f32)>,
    last: Option<f32>,
}

impl Curve {
    fn to(&mut self, painter: &Painter, x: f32, y: f32, stroke: Stroke) {
        match &mut self.column {
            Some((column, top, bottom)) if x - *column < 0.5 => {
                (*top, *bottom) = (top.min(y), bottom.max(y));
            }
            _ => {
                self.flush();
                if let Some(last) = self.last {
                    self.points.push(pos2(x, last));
                }
                self.points.push(pos2(x, y));
                self.column = Some((x, y, y));
            }
        }
        self.last = Some(y);
        // A long line is drawn in pieces of bounded length.
        if self.points.len() > 4000 {
            let from = self.points.last().copied();
            painter.line(std::mem::take(&mut self.points), stroke);
            self.points.extend(from);
        }
    }

    fn flush(&mut self) {
        if let (Some((x, top, bottom)), Some(last)) = (self.column.take(), self.last)
            && top < bottom
        {
            self.points.extend([pos2(x, top), pos2(x, bottom), pos2(x, last)]);
        }
    }

    fn end(&mut self, painter: &Painter, x: f32, stroke: Stroke) {
        self.flush();
        if let Some(last) = self.last.take() {
            if self.points.last().is_some_and(|point| point.x < x) {
                self.points.push(pos2(x, last));
            }
            painter.line(std::mem::take(&mut self.points), stroke);
        }
    }
}

#[cfg(test)]
mod tests {
    use jde_types::Value as _;

    use super::super::field;
    use super::*;

    #[test]
    fn after_a_jump_a_curve_has_a_gap_and_a_whole_one_has_none() {
        let place = field::find(&f64::describe(), "").expect("it is a number");
        let variable = "a.b".to_owned();
        let mut signal = Signal::new("a.b".to_owned(), Source::Field { variable, place }, 0);
        signal.take(1.0, "a.b", Some(5.0.as_bytes()));
        signal.take(2.0, "a.b", Some(6.0.as_bytes()));
        signal.interrupt();
        signal.take(60.0, "a.b", Some(7.0.as_bytes()));
        let at = |signal: &Signal| [1.5, 30.0, 61.0].map(|time| signal.at(time));
        assert_eq!(at(&signal), [Some(5.0), None, Some(7.0)]);
        let mut whole = Trace::new(10);
        [(1.0, 5.0), (20.0, 8.0), (60.0, 7.0)]
            .into_iter()
            .for_each(|(time, value)| whole.add(time, value));
        signal.whole = Some(Arc::new(whole));
        assert_eq!(at(&signal), [Some(5.0), Some(8.0), Some(7.0)]);
        assert_eq!(signal.present(25.0), Some(8.0), "the value of the position");
    }
}
