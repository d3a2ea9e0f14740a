//! The right half of a schema's row: its states over time, and its events. It draws by columns of the screen,
//! and examines only the visible part.

use eframe::egui::{Mesh, Painter, Rect, vec2};
use jde_records::snapshot::SchemaView;
use jde_timeline::Mark;

use super::axis::Scale;
use super::bands::{self, ColumnRun};
use super::event_signs;
use super::input::Input;
use super::strips::{by_column, nearest};
use crate::style::{self, Style};

/// Maximum number of events examined in one column.
const EXAMINED_EVENTS: usize = 16;

/// Draws the traces of all rows of a frame.
pub(super) struct Traces<'a> {
    pub(super) seen: &'a Input<'a>,
    pub(super) scale: Scale,
    pub(super) style: &'a Style,
    /// Width of a column: one pixel, in points.
    pub(super) pixel: f32,
    runs: Vec<ColumnRun>,
    mesh: Mesh,
}

impl<'a> Traces<'a> {
    pub(super) fn new(seen: &'a Input<'a>, scale: Scale, style: &'a Style, pixel: f32) -> Self {
        Self {
            seen,
            scale,
            style,
            pixel,
            runs: Vec::new(),
            mesh: Mesh::default(),
        }
    }

    /// Draws a schema's states and events.
    pub(super) fn schema(&mut self, painter: &Painter, rect: Rect, view: &SchemaView) {
        let row = rect.shrink2(vec2(0.0, 3.0));
        let Some(known) = self.seen.timeline.schema(&view.name) else {
            return;
        };
        if !known.states.is_empty() {
            let columns = (row.width() / self.pixel).floor() as usize;
            bands::runs(
                &known.states,
                &self.scale,
                columns,
                self.seen.end_s,
                &mut self.runs,
            );
            bands::draw(&mut self.mesh, &self.runs, row, self.pixel, self.style);
            painter.add(std::mem::take(&mut self.mesh));
        }
        let marks = &known.marks;
        by_column(marks, Mark::time_s, &self.scale, 4.0, |first, last| {
            let worst = marks
                .range(first..=last.min(first + EXAMINED_EVENTS))
                .map(|mark| mark.kind)
                .max();
            let x = self.scale.x(marks[first].time_s());
            if let Some(worst) = worst {
                event_signs::draw(painter, x, rect, worst, self.style);
            }
        });
    }

    /// Describes a schema at a position of the screen: its state then, and the nearest event.
    pub(super) fn description_at(&self, view: &SchemaView, x: f32) -> Vec<String> {
        let time = self.scale.time(x);
        let mut lines = Vec::new();
        let Some(known) = self.seen.timeline.schema(&view.name) else {
            return lines;
        };
        if time <= self.seen.end_s
            && let Some((state, next)) = known.states.at_s(time)
        {
            let until = next.map_or(self.seen.end_s, |next| next.from_s());
            lines.push(format!(
                "{} for {}, from {:.3} s",
                state.value.name(),
                style::time::span(until - state.from_s()),
                state.from_s()
            ));
        }
        if let Some(index) = nearest(&known.marks, Mark::time_s, &self.scale, x) {
            let mark = &known.marks[index];
            lines.push(format!("{:.3} s: {}", mark.time_s(), mark.text));
        }
        lines
    }
}
