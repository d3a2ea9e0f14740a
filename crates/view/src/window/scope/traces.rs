//! The right half of rows: states over time, who won in each group, switches, and what happened. Each draws by columns of the
//! screen and looks at what is in sight only.

use std::collections::VecDeque;

use eframe::egui::{Align2, Color32, Mesh, Painter, Rangef, Rect, Shape, Stroke, pos2, vec2};
use jde_core::State;
use jde_host::snapshot::{GroupView, SchemaView};
use jde_panel::Ink;

use super::axis::Scale;
use super::bands::{self, Run};
use super::index::{Index, Mark, Sign, Switch};
use super::ink;
use super::seen::Seen;
use crate::look::{self, Look};

/// How near to something a click or a pointer is, points.
const NEAR: f32 = 7.0;
/// What happened in one column that is looked at.
const LOOKED_AT: usize = 16;

/// What is drawn into all rows of a frame.
pub(super) struct Traces<'a> {
    pub(super) seen: &'a Seen<'a>,
    pub(super) index: &'a Index,
    pub(super) scale: Scale,
    pub(super) look: &'a Look,
    /// Width of a column: one pixel.
    pub(super) pixel: f32,
    runs: Vec<Run>,
    mesh: Mesh,
}

impl<'a> Traces<'a> {
    pub(super) fn new(
        seen: &'a Seen<'a>,
        index: &'a Index,
        scale: Scale,
        look: &'a Look,
        pixel: f32,
    ) -> Self {
        Self {
            seen,
            index,
            scale,
            look,
            pixel,
            runs: Vec::new(),
            mesh: Mesh::default(),
        }
    }

    /// A schema's states and what happened to it.
    pub(super) fn schema(&mut self, painter: &Painter, rect: Rect, view: &SchemaView) {
        let row = rect.shrink2(vec2(0.0, 3.0));
        if let Some(list) = self.seen.past.bands(&view.name) {
            let columns = (row.width() / self.pixel).floor() as usize;
            bands::runs(list, &self.scale, columns, self.seen.now(), &mut self.runs);
            bands::draw(&mut self.mesh, &self.runs, row, self.pixel, self.look);
            painter.add(std::mem::take(&mut self.mesh));
        }
        let Some(marks) = self.index.marks(&view.name) else {
            return;
        };
        by_column(
            marks,
            |mark| mark.time,
            &self.scale,
            4.0,
            |first, last| {
                let worst = marks
                    .range(first..=last.min(first + LOOKED_AT))
                    .map(|mark| mark.sign)
                    .max();
                let x = self.scale.x(marks[first].time);
                if let Some(worst) = worst {
                    sign(painter, x, rect, worst, self.look);
                }
            },
        );
    }

    /// Who won in a group: names as long as there is room for them.
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
            |one, last| {
                let x = self.scale.x(switches[one].time);
                segment(from, x, winner);
                (from, winner) = (x, switches[last].to);
                if last > one {
                    // More switches than there is room for.
                    let busy = Rect::from_min_max(pos2(x, row.top()), pos2(x + 2.0, row.bottom()));
                    painter.rect_filled(busy, 0.0, look::ink(Ink::Accent, self.look));
                    from = x + 2.0;
                }
            },
        );
        let end = self.scale.x(self.seen.now()).min(row.right());
        segment(from, end, winner);
    }

    /// Since when somebody is known to win in a group of which no switch is known any more, s: a winner's state is one as well.
    fn won_since(&self, group: &GroupView) -> f64 {
        let since = self.seen.past.since().unwrap_or(0.0);
        let winner = group
            .winner
            .and_then(|winner| self.seen.snapshot.schemas.get(winner));
        let bands = winner.and_then(|winner| self.seen.past.bands(&winner.name));
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
        let accent = look::ink(Ink::Accent, self.look);
        painter.rect_filled(rect.shrink2(vec2(0.5, 0.0)), 2.0, accent.gamma_multiply(0.28));
        if rect.width() > 24.0 {
            let text = if self.look.dark {
                Color32::from_gray(215)
            } else {
                Color32::from_gray(40)
            };
            let inside = rect.shrink2(vec2(4.0, 0.0));
            ink::write(painter, inside, &winner.name, ink::small(), text);
        }
    }

    /// The switches of a group: a tick at the new winner, and a line to it from the old one.
    ///
    /// `middle` tells the height of a schema's row, if it has one.
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
        let plain = if self.look.dark {
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
                    look::ink(Ink::Goal, self.look)
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
            let tick = ink::ROW / 2.0 - 3.0;
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

    /// The switch of a group that is nearest to a place of the screen, if one is near.
    pub(super) fn switch_at(&self, group: &str, x: f32) -> Option<u64> {
        let switches = self.index.group(group)?;
        let place = nearest(switches, |switch| switch.time, &self.scale, x)?;
        Some(switches[place].number)
    }

    /// What there is to say of a schema at a place of the screen.
    pub(super) fn words_at(&self, view: &SchemaView, x: f32) -> Vec<String> {
        let time = self.scale.time(x);
        let mut words = Vec::new();
        if let Some(list) = self.seen.past.bands(&view.name)
            && time <= self.seen.now()
            && let Some(place) = list.partition_point(|band| band.from <= time).checked_sub(1)
        {
            let until = list.get(place + 1).map_or(self.seen.now(), |next| next.from);
            words.push(format!(
                "{} for {}, from {:.3} s",
                bands::word(list[place].state),
                look::time::span(until - list[place].from),
                list[place].from
            ));
        }
        if let Some(marks) = self.index.marks(&view.name)
            && let Some(place) = nearest(marks, |mark| mark.time, &self.scale, x)
        {
            let Mark { time, text, .. } = &marks[place];
            words.push(format!("{time:.3} s: {text}"));
        }
        words
    }
}

/// Goes through what is in sight, column by column of `width` points: the first and the last of each column that has any.
fn by_column<T>(
    list: &VecDeque<T>,
    time: impl Fn(&T) -> f64,
    scale: &Scale,
    width: f32,
    mut each: impl FnMut(usize, usize),
) {
    let column = f64::from(width) * scale.per_point();
    let mut first = list.partition_point(|item| time(item) <= scale.from);
    while let Some(item) = list.get(first).filter(|item| time(item) <= scale.to) {
        let end = scale.from + (((time(item) - scale.from) / column).floor() + 1.0) * column;
        let before = |place: usize| list.get(place).is_some_and(|item| time(item) < end);
        let (mut last, mut step) = (first, 1);
        while before(last + step) {
            last += step;
            step *= 2;
        }
        while step > 0 {
            if before(last + step) {
                last += step;
            }
            step /= 2;
        }
        each(first, last);
        first = last + 1;
    }
}

fn nearest<T>(list: &VecDeque<T>, time: impl Fn(&T) -> f64, scale: &Scale, x: f32) -> Option<usize> {
    let after = list.partition_point(|item| time(item) <= scale.time(x));
    let away = |place: usize| {
        Some((
            list.get(place).map(|item| (scale.x(time(item)) - x).abs())?,
            place,
        ))
    };
    let both = [after.checked_sub(1).and_then(away), away(after)];
    let nearest = both
        .into_iter()
        .flatten()
        .min_by(|one, other| one.0.total_cmp(&other.0))?;
    (nearest.0 <= NEAR).then_some(nearest.1)
}

fn sign(painter: &Painter, x: f32, row: Rect, sign: Sign, look: &Look) {
    let color = ink::sign(sign, look);
    let top = row.top() + 1.0;
    let polygon = |corners: &[(f32, f32)]| {
        let corners = corners.iter().map(|&(dx, dy)| pos2(x + dx, top + dy)).collect();
        painter.add(Shape::convex_polygon(corners, color, Stroke::NONE));
    };
    match sign {
        Sign::Fault => {
            let line = Stroke::new(2.0, color);
            let (middle, arm) = (row.center().y, 4.5);
            painter.line_segment([pos2(x - arm, middle - arm), pos2(x + arm, middle + arm)], line);
            painter.line_segment([pos2(x - arm, middle + arm), pos2(x + arm, middle - arm)], line);
        }
        Sign::Overrun => polygon(&[(-4.0, 7.0), (0.0, 0.0), (4.0, 7.0)]),
        Sign::Operator => {
            polygon(&[(0.0, 0.0), (7.0, 3.0), (0.0, 6.0)]);
            painter.vline(x, Rangef::new(top, top + 11.0), Stroke::new(1.3, color));
        }
        Sign::Refused => {
            painter.circle_stroke(pos2(x, top + 3.5), 3.0, Stroke::new(1.3, color));
        }
        Sign::Well => {
            painter.circle_filled(pos2(x, top + 3.5), 2.5, color);
        }
    }
}

/// The times along the upper edge, and a grid below them.
pub(super) fn ruler(painter: &Painter, head: Rect, body: Rect, scale: &Scale, division: f64, look: &Look) {
    let (line, text) = if look.dark {
        (Color32::from_gray(52), Color32::from_gray(150))
    } else {
        (Color32::from_gray(222), Color32::from_gray(100))
    };
    let unit = painter.text(head.right_top(), Align2::RIGHT_TOP, "s", ink::small(), text);
    let digits = (-division.log10().floor()).clamp(0.0, 6.0) as usize;
    let mut step = (scale.from / division).ceil();
    let mut free = head.left();
    while step * division <= scale.to {
        let time = step * division;
        let x = scale.x(time);
        painter.vline(x, body.y_range(), Stroke::new(1.0, line));
        painter.vline(
            x,
            Rangef::new(head.bottom() - 4.0, head.bottom()),
            Stroke::new(1.0, text),
        );
        let galley = painter.layout_no_wrap(format!("{time:.digits$}"), ink::small(), text);
        let left = x - galley.size().x / 2.0;
        if left >= free && left + galley.size().x <= unit.left() - 3.0 && time >= 0.0 {
            free = left + galley.size().x + 8.0;
            painter.galley(pos2(left, head.top() + 1.0), galley, text);
        }
        step += 1.0;
    }
}

#[cfg(test)]
mod tests {
    use super::super::fixture;
    use super::*;
    use crate::look::Units;

    fn scale(from: f64, to: f64) -> Scale {
        let x = Rangef::new(0.0, 100.0);
        Scale { from, to, x }
    }

    #[test]
    fn what_falls_into_one_column_comes_as_one() {
        let times: VecDeque<f64> = [-1.0, 0.1, 0.2, 0.3, 5.0, 9.9, 12.0].into();
        let mut found = Vec::new();
        by_column(
            &times,
            |time| *time,
            &scale(0.0, 10.0),
            10.0,
            |first, last| found.push((first, last)),
        );
        assert_eq!(found, [(1, 3), (4, 4), (5, 5)]);
    }

    #[test]
    fn a_group_whose_switches_are_forgotten_is_won_since_its_winner_is_one() {
        let mut fixed = fixture::navigation();
        let mut schemas = fixed.snapshot.schemas.iter();
        let place = schemas.position(|schema| schema.name == "teleop");
        fixed.change(2.5, "teleop", "ready", "winner");
        fixed.snapshot.schemas[place.expect("it is there")].state = State::Winner;
        fixed.past.see(&fixed.snapshot);
        let won = |fixed: &fixture::Fixed, winner| {
            let (seen, index, scale) = (fixed.seen(), Index::default(), scale(0.0, 10.0));
            let look = Look {
                dark: true,
                units: Units::default(),
            };
            let group = GroupView {
                winner,
                ..fixture::group("roots", None, &[0])
            };
            Traces::new(&seen, &index, scale, &look, 1.0).won_since(&group)
        };
        assert_eq!(won(&fixed, place), 2.5);
        assert_eq!(
            Some(won(&fixed, None)),
            fixed.past.since(),
            "of nobody nothing is known"
        );
    }

    #[test]
    fn only_what_is_near_is_pointed_at() {
        let times: VecDeque<f64> = [1.0, 2.0].into();
        let at = |x| nearest(&times, |time| *time, &scale(0.0, 10.0), x);
        assert_eq!(
            [at(4.0), at(14.0), at(16.0), at(26.0), at(28.0)],
            [Some(0), Some(0), Some(1), Some(1), None]
        );
    }
}
