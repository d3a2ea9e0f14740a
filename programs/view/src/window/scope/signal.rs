//! A number over time: its values and its curve.

use std::collections::VecDeque;

use eframe::egui::{Align2, Color32, Painter, Pos2, Rect, Stroke, pos2};

use super::axis::Scale;
use super::field::FieldPath;
use super::paint;
use crate::style::Style;

/// Maximum number of values kept: 27 minutes at 50 Hz.
const KEPT: usize = 80_000;

/// A number over time.
#[derive(Debug)]
pub(super) struct Signal {
    /// The variable and the path in it, as requested.
    pub(super) name: String,
    /// The variable.
    pub(super) variable: String,
    /// The location of the number in the variable, or why there is none.
    pub(super) place: Result<FieldPath, String>,
    /// Index of the color.
    pub(super) color: usize,
    values: VecDeque<(f64, f64)>,
}

impl Signal {
    pub(super) fn new(
        name: String,
        variable: String,
        place: Result<FieldPath, String>,
        color: usize,
    ) -> Self {
        Self {
            name,
            variable,
            place,
            color,
            values: VecDeque::new(),
        }
    }

    /// Adds a value at a time in s. Values at that time or later are removed first, as when a recording
    /// jumped back.
    pub(super) fn take(&mut self, time: f64, bytes: Option<&[u8]>) {
        let Ok(place) = &self.place else { return };
        while self.values.pop_back_if(|last| last.0 >= time).is_some() {}
        // Without a value, NaN makes a gap in the curve.
        let value = bytes.and_then(|bytes| place.read(bytes)).unwrap_or(f64::NAN);
        if self.values.len() == KEPT {
            self.values.pop_front();
        }
        self.values.push_back((time, value));
    }

    /// The value at a time: the last one written before it.
    pub(super) fn at(&self, time: f64) -> Option<f64> {
        let after = self.values.partition_point(|value| value.0 <= time);
        let (_, value) = self.values.get(after.checked_sub(1)?)?;
        value.is_finite().then_some(*value)
    }

    /// The newest value.
    pub(super) fn last(&self) -> Option<f64> {
        self.values
            .back()
            .map(|(_, value)| *value)
            .filter(|value| value.is_finite())
    }

    /// Formats a value in the user's units.
    pub(super) fn show(&self, value: f64, style: &Style) -> String {
        let unit = self.place.as_ref().map_or("", |place| &place.unit);
        style.units.show(value, unit)
    }

    /// Draws the curve. Each value lasts until the next.
    pub(super) fn draw(&self, painter: &Painter, rect: Rect, scale: &Scale, now: f64, style: &Style) {
        let first = self
            .values
            .partition_point(|value| value.0 <= scale.from)
            .saturating_sub(1);
        let shown = || self.values.range(first..).take_while(|value| value.0 <= scale.to);
        let (mut least, mut most) = (f64::INFINITY, f64::NEG_INFINITY);
        for (_, value) in shown().filter(|(_, value)| value.is_finite()) {
            (least, most) = (least.min(*value), most.max(*value));
        }
        let faint = Color32::from_gray(128);
        if least > most {
            let text = match &self.place {
                Ok(_) => "no value yet",
                Err(reason) => reason,
            };
            paint::write(painter, rect.shrink(6.0), text, paint::small(), faint);
            return;
        }
        let margin = ((most - least) * 0.08)
            .max(least.abs().max(most.abs()) * 1e-6)
            .max(1e-9);
        let (bottom, top) = (least - margin, most + margin);
        let y = |value: f64| rect.bottom() - ((value - bottom) / (top - bottom)) as f32 * rect.height();
        let color = paint::signal_color(self.color, style);
        let stroke = Stroke::new(1.4, color);
        let mut curve = Curve::default();
        for &(time, value) in shown() {
            let x = scale.x(time).max(rect.left());
            if value.is_finite() {
                curve.to(painter, x, y(value), stroke);
            } else {
                curve.end(painter, x, stroke);
            }
        }
        curve.end(painter, scale.x(now).min(rect.right()), stroke);
        for (value, at, align) in [
            (most, rect.left_top(), Align2::LEFT_TOP),
            (least, rect.left_bottom(), Align2::LEFT_BOTTOM),
        ] {
            painter.text(at, align, self.show(value, style), paint::small(), faint);
        }
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
    use jde_types::Value;

    use super::super::field;
    use super::*;

    #[test]
    fn a_value_holds_until_the_next_one_and_a_jump_back_in_time_removes_later_values() {
        let place = field::find(&f64::describe(), "");
        let mut signal = Signal::new("a.b".to_owned(), "a.b".to_owned(), place, 0);
        for (time, value) in [(1.0, 10.0_f64), (2.0, 20.0), (3.0, 30.0)] {
            signal.take(time, Some(value.as_bytes()));
        }
        assert_eq!(
            [0.5, 1.0, 2.9, 9.0].map(|time| signal.at(time)),
            [None, Some(10.0), Some(20.0), Some(30.0)]
        );
        signal.take(1.5, Some(15.0_f64.as_bytes()));
        assert_eq!(signal.at(9.0), Some(15.0));
        signal.take(4.0, None);
        assert_eq!((signal.at(5.0), signal.at(3.0)), (None, Some(15.0)));
    }
}
