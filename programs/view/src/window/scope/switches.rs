//! The winners of each group over time, and the switches between them.

use std::collections::VecDeque;

use eframe::egui::{Color32, Painter, Rangef, Rect, Shape, Stroke, pos2, vec2};
use jde_panel::Ink;
use jde_records::snapshot::GroupView;
use jde_timeline::{Interval, Switch};

use super::paint;
use super::strips::{by_column, nearest};
use super::traces::Traces;
use crate::style;

impl Traces<'_> {
    /// Draws the winners of a group, with their names where they fit.
    pub(super) fn group(&self, painter: &Painter, rect: Rect, group: &GroupView) {
        let Some(known) = self.seen.timeline.group(&group.name) else {
            return;
        };
        let row = rect.shrink2(vec2(0.0, 5.0));
        let first = known
            .winners
            .partition_point(|winner| winner.from_s() <= self.scale.from);
        let winners: VecDeque<_> = known.winners.iter().skip(first.saturating_sub(1)).collect();
        let mut from = row.left();
        let mut winner = winners
            .front()
            .filter(|winner| winner.from_s() <= self.scale.from);
        let segment = |from: f32, to: f32, winner: Option<&Interval<Option<usize>>>| {
            self.segment(
                painter,
                row,
                Rangef::new(from, to),
                winner.and_then(|winner| winner.value),
            );
        };
        by_column(&winners, Interval::from_s, &self.scale, 2.0, |first, last| {
            let x = self.scale.x(winners[first].from_s());
            segment(from, x, winner);
            (from, winner) = (x, Some(&winners[last]));
            if last > first {
                // More switches than can be shown separately.
                let crowded = Rect::from_min_max(pos2(x, row.top()), pos2(x + 2.0, row.bottom()));
                painter.rect_filled(crowded, 0.0, style::color_of(Ink::Accent, self.style));
                from = x + 2.0;
            }
        });
        let end = self.scale.x(self.seen.end_s).min(row.right());
        segment(from, end, winner);
    }

    fn segment(&self, painter: &Painter, row: Rect, x: Rangef, winner: Option<usize>) {
        let Some(winner) = winner.and_then(|winner| self.seen.snapshot.schemas.get(winner)) else {
            return;
        };
        let rect = Rect::from_x_y_ranges(x, row.y_range()).intersect(row);
        if rect.width() <= 0.0 {
            return;
        }
        let accent = style::color_of(Ink::Accent, self.style);
        painter.rect_filled(rect.shrink2(vec2(0.5, 0.0)), 2.0, accent.gamma_multiply(0.28));
        if rect.width() > 24.0 {
            let text = if self.style.dark {
                Color32::from_gray(215)
            } else {
                Color32::from_gray(40)
            };
            let inside = rect.shrink2(vec2(4.0, 0.0));
            paint::write_if_readable(painter, inside, &winner.name, paint::small(), text);
        }
    }

    /// Draws the switches of a group: a tick at the new winner, and a line to it from the old one.
    ///
    /// `middle` returns the vertical center of a schema's row, if it has one.
    pub(super) fn switches(
        &self,
        painter: &Painter,
        group: &GroupView,
        middle: &dyn Fn(usize) -> Option<f32>,
        opened: Option<u64>,
    ) {
        let Some(known) = self.seen.timeline.group(&group.name) else {
            return;
        };
        let switches = &known.switches;
        let plain = if self.style.dark {
            Color32::from_gray(240)
        } else {
            Color32::from_gray(20)
        };
        by_column(
            switches,
            Switch::time_s,
            &self.scale,
            self.pixel,
            |first, last| {
                let switch = &switches[last];
                let is_opened =
                    opened.is_some() && (first..=last).any(|place| switches[place].number == opened);
                let color = if is_opened {
                    style::color_of(Ink::Goal, self.style)
                } else {
                    plain
                };
                self.switch(painter, switch, middle, color, is_opened);
            },
        );
    }

    fn switch(
        &self,
        painter: &Painter,
        switch: &Switch,
        middle: &dyn Fn(usize) -> Option<f32>,
        color: Color32,
        opened: bool,
    ) {
        let x = self.scale.x(switch.time_s());
        let (from, to) = (switch.from.and_then(middle), switch.to.and_then(middle));
        if let (Some(from), Some(to)) = (from, to) {
            let line = Stroke::new(
                if opened { 2.0 } else { 1.0 },
                color.gamma_multiply(if opened { 1.0 } else { 0.55 }),
            );
            painter.line_segment([pos2(x, from), pos2(x, to)], line);
        }
        if let Some(y) = to {
            let tick = paint::ROW / 2.0 - 3.0;
            painter.line_segment(
                [pos2(x, y - tick), pos2(x, y + tick)],
                Stroke::new(if opened { 2.5 } else { 1.5 }, color),
            );
            let corners = [(-3.5, -tick), (3.5, -tick), (0.0, -tick + 4.5)];
            let corners = corners.map(|(dx, dy)| pos2(x + dx, y + dy));
            painter.add(Shape::convex_polygon(corners.to_vec(), color, Stroke::NONE));
        } else if let Some(y) = from {
            painter.circle_stroke(pos2(x, y), 3.0, Stroke::new(1.5, color));
        }
    }

    /// The number of the group's switch nearest to a position of the screen, if it is near.
    pub(super) fn switch_at(&self, group: &str, x: f32) -> Option<u64> {
        let switches = &self.seen.timeline.group(group)?.switches;
        switches[nearest(switches, Switch::time_s, &self.scale, x)?].number
    }
}
