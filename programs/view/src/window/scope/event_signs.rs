//! The signs of a schema's events.

use eframe::egui::{Painter, Rangef, Rect, Shape, Stroke, pos2};

use jde_timeline::MarkKind;

use super::paint;
use crate::style::Style;

/// Draws a sign at a position of a row.
pub(super) fn draw(painter: &Painter, x: f32, row: Rect, kind: MarkKind, style: &Style) {
    let color = paint::mark(kind, style);
    let top = row.top() + 1.0;
    let polygon = |corners: &[(f32, f32)]| {
        let corners = corners.iter().map(|&(dx, dy)| pos2(x + dx, top + dy)).collect();
        painter.add(Shape::convex_polygon(corners, color, Stroke::NONE));
    };
    match kind {
        MarkKind::Fault => {
            let line = Stroke::new(2.0, color);
            let (middle, arm) = (row.center().y, 4.5);
            painter.line_segment([pos2(x - arm, middle - arm), pos2(x + arm, middle + arm)], line);
            painter.line_segment([pos2(x - arm, middle + arm), pos2(x + arm, middle - arm)], line);
        }
        MarkKind::Overrun
        | MarkKind::ArbitrationFailed
        | MarkKind::Late
        | MarkKind::Stalled
        | MarkKind::Chattering => polygon(&[(-4.0, 7.0), (0.0, 0.0), (4.0, 7.0)]),
        MarkKind::Operator | MarkKind::Reloaded | MarkKind::Standstill | MarkKind::Triggered => {
            polygon(&[(0.0, 0.0), (7.0, 3.0), (0.0, 6.0)]);
            painter.vline(x, Rangef::new(top, top + 11.0), Stroke::new(1.3, color));
        }
        MarkKind::Refused | MarkKind::Limited => {
            painter.circle_stroke(pos2(x, top + 3.5), 3.0, Stroke::new(1.3, color));
        }
        MarkKind::Recovered | MarkKind::Calmed | MarkKind::Ended | MarkKind::Other | MarkKind::Delayed => {
            painter.circle_filled(pos2(x, top + 3.5), 2.5, color);
        }
    }
}
