//! Drawing of the time axis.

use eframe::egui::{Align2, Color32, Painter, Rangef, Rect, Stroke, pos2};

use super::axis::Scale;
use super::paint;
use crate::style::Style;

/// Draws the times along the upper edge, and the grid below them.
pub(super) fn draw(painter: &Painter, head: Rect, body: Rect, scale: &Scale, division: f64, style: &Style) {
    let (line, text) = if style.dark {
        (Color32::from_gray(52), Color32::from_gray(150))
    } else {
        (Color32::from_gray(222), Color32::from_gray(100))
    };
    let unit = painter.text(head.right_top(), Align2::RIGHT_TOP, "s", paint::small(), text);
    let digits = (-division.log10().floor()).clamp(0.0, 6.0) as usize;
    let mut step = (scale.from / division).ceil();
    let mut free = head.left();
    while step * division <= scale.to {
        // Without a negative zero.
        let time = step * division + 0.0;
        let x = scale.x(time);
        painter.vline(x, body.y_range(), Stroke::new(1.0, line));
        painter.vline(
            x,
            Rangef::new(head.bottom() - 4.0, head.bottom()),
            Stroke::new(1.0, text),
        );
        let galley = painter.layout_no_wrap(format!("{time:.digits$}"), paint::small(), text);
        let left = x - galley.size().x / 2.0;
        if left >= free && left + galley.size().x <= unit.left() - 3.0 && time >= 0.0 {
            free = left + galley.size().x + 8.0;
            painter.galley(pos2(left, head.top() + 1.0), galley, text);
        }
        step += 1.0;
    }
}
