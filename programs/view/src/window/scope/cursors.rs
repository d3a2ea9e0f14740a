//! Two lines across all traces, which can be dragged. They show two times, the time between them, and its
//! frequency.

use eframe::egui::{Align2, Painter, Rect, Stroke, StrokeKind, pos2, vec2};
use jde_panel::Ink;
use serde::{Deserialize, Serialize};

use super::axis::Scale;
use super::paint;
use crate::style::{self, Style, time};

/// A frequency in Hz with four digits: "0.1500 Hz", "12.50 Hz".
fn frequency(hertz: f64) -> String {
    let digits = (3.0 - hertz.log10().floor()).clamp(0.0, 4.0) as usize;
    format!("{hertz:.digits$} Hz")
}

/// Distance within which a drag moves a line, in points.
const GRAB_DISTANCE: f32 = 6.0;

/// Two times.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Cursors {
    /// The times in s, while the cursors are shown.
    pub(super) at: Option<[f64; 2]>,
    /// The index of the cursor that is being dragged.
    #[serde(skip)]
    held: Option<usize>,
}

impl Cursors {
    /// Hides the cursors, or shows them at thirds of the window.
    pub(super) fn toggle(&mut self, scale: &Scale) {
        let third = (scale.to - scale.from) / 3.0;
        self.at = match self.at {
            Some(_) => None,
            None => Some([scale.from + third, scale.to - third]),
        };
    }

    /// Takes the cursor near a position of the screen. Returns whether there is one.
    pub(super) fn take(&mut self, scale: &Scale, x: f32) -> bool {
        let times = self
            .at
            .unwrap_or([f64::NAN; 2])
            .map(|time| (scale.x(time) - x).abs());
        self.held = (0..2)
            .filter(|&cursor| times[cursor] <= GRAB_DISTANCE)
            .min_by(|&a, &b| times[a].total_cmp(&times[b]));
        self.held.is_some()
    }

    /// Moves the taken cursor. Returns whether there is one.
    pub(super) fn drag(&mut self, time: f64) -> bool {
        match (self.held, &mut self.at) {
            (Some(held), Some(times)) => {
                times[held] = time;
                true
            }
            _ => false,
        }
    }

    pub(super) fn let_go(&mut self) {
        self.held = None;
    }

    /// Both times, their difference and its frequency, as text.
    pub(super) fn text(&self) -> Option<String> {
        let [first, second] = self.at?;
        let difference = second - first;
        let frequency = if difference == 0.0 {
            String::new()
        } else {
            format!(" ({})", frequency(1.0 / difference.abs()))
        };
        Some(format!(
            "A {first:.4} s   B {second:.4} s   B − A {}{frequency}",
            time::span(difference)
        ))
    }

    pub(super) fn draw(&self, painter: &Painter, head: Rect, body: Rect, scale: &Scale, style: &Style) {
        let Some(times) = self.at else { return };
        let color = style::color_of(Ink::Seen, style);
        for (time, name) in times.into_iter().zip(["A", "B"]) {
            if !scale.holds(time) {
                continue;
            }
            let x = scale.x(time);
            painter.vline(x, body.y_range(), Stroke::new(1.3, color));
            let tag = Rect::from_center_size(pos2(x, head.bottom() - 7.0), vec2(13.0, 13.0));
            let ground = if style.dark {
                eframe::egui::Color32::BLACK
            } else {
                eframe::egui::Color32::WHITE
            };
            painter.rect(tag, 2.0, ground, Stroke::new(1.0, color), StrokeKind::Inside);
            painter.text(tag.center(), Align2::CENTER_CENTER, name, paint::small(), color);
        }
    }
}
