//! The winners of each group over time, and the switches between them.

use std::collections::VecDeque;

use eframe::egui::{Color32, Painter, Rangef, Rect, Shape, Stroke, pos2, vec2};
use jde_core::State;
use jde_panel::Ink;
use jde_records::snapshot::GroupView;

use super::index::Switch;
use super::paint;
use super::strips::{by_column, nearest};
use super::traces::Traces;
use crate::style;

impl Traces<'_> {
    /// Draws the winners of a group, with their names where they fit.
    pub(super) fn group(&self, painter: &Painter, rect: Rect, group: &GroupView) {
        let row = rect.shrink2(vec2(0.0, 5.0));
        let none = VecDeque::new();
        let switches = self.index.group(&group.name).unwrap_or(&none);
        let first = switches.partition_point(|switch| switch.time <= self.scale.from);
        let mut winner = match first.checked_sub(1).and_then(|before| switches.get(before)) {
            Some(before) => before.to,
            None => switches.front().map_or(group.winner, |first| first.from),
        };
        let begin = if switches.is_empty() {
            self.won_since(group)
        } else {
            0.0
        };
        let mut from = row.left().max(self.scale.x(begin));
        let segment = |from: f32, to: f32, winner: Option<usize>| {
            self.segment(painter, row, Rangef::new(from, to), winner);
        };
        by_column(
            switches,
            |switch| switch.time,
            &self.scale,
            2.0,
            |first, last| {
                let x = self.scale.x(switches[first].time);
                segment(from, x, winner);
                (from, winner) = (x, switches[last].to);
                if last > first {
                    // More switches than can be shown separately.
                    let crowded = Rect::from_min_max(pos2(x, row.top()), pos2(x + 2.0, row.bottom()));
                    painter.rect_filled(crowded, 0.0, style::color_of(Ink::Accent, self.style));
                    from = x + 2.0;
                }
            },
        );
        let end = self.scale.x(self.seen.now()).min(row.right());
        segment(from, end, winner);
    }

    /// For a group without kept switches: since when its winner is known, in s. A winner's state shows this
    /// as well.
    fn won_since(&self, group: &GroupView) -> f64 {
        let since = self.seen.past.since().unwrap_or(0.0);
        let winner = group
            .winner
            .and_then(|winner| self.seen.snapshot.schemas.get(winner));
        let bands = winner.and_then(|winner| self.seen.past.states(&winner.name));
        let present = bands
            .and_then(VecDeque::back)
            .filter(|band| band.state == State::Winner);
        present.map_or(since, |band| band.from.min(since))
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
            paint::write_name(painter, inside, &winner.name, paint::small(), text);
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
        let Some(switches) = self.index.group(&group.name) else {
            return;
        };
        let plain = if self.style.dark {
            Color32::from_gray(240)
        } else {
            Color32::from_gray(20)
        };
        by_column(
            switches,
            |switch| switch.time,
            &self.scale,
            self.pixel,
            |first, last| {
                let switch = &switches[last];
                let is_opened =
                    opened.is_some_and(|number| (switches[first].number..=switch.number).contains(&number));
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
        let x = self.scale.x(switch.time);
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
        let switches = self.index.group(group)?;
        let place = nearest(switches, |switch| switch.time, &self.scale, x)?;
        Some(switches[place].number)
    }
}

#[cfg(test)]
mod tests {
    use super::super::axis::Scale;
    use super::super::fixture;
    use super::super::index::Index;
    use super::*;
    use crate::style::{Style, Units};

    #[test]
    fn without_kept_switches_a_group_is_won_since_its_winners_state_began() {
        let mut fixed = fixture::navigation();
        let mut schemas = fixed.snapshot.schemas.iter();
        let teleop = schemas.position(|schema| schema.name == "teleop");
        fixed.change(2.5, "teleop", State::Ready, State::Winner);
        fixed.snapshot.schemas[teleop.expect("the hierarchy has teleop")].state = State::Winner;
        fixed.past.add_snapshot(&fixed.snapshot);
        let won = |fixed: &fixture::Fixed, winner| {
            let (seen, index) = (fixed.input(), Index::default());
            let scale = Scale {
                from: 0.0,
                to: 10.0,
                x: Rangef::new(0.0, 100.0),
            };
            let style = Style {
                dark: true,
                units: Units::default(),
            };
            let group = GroupView {
                winner,
                ..fixture::group("roots", None, &[0])
            };
            Traces::new(&seen, &index, scale, &style, 1.0).won_since(&group)
        };
        assert_eq!(won(&fixed, teleop), 2.5);
        assert_eq!(
            Some(won(&fixed, None)),
            fixed.past.since(),
            "without a winner, the observation's start is used"
        );
    }
}
