//! Small parts of the oscilloscope's painting: truncated text, buttons with a drawn sign, colors of signals.

use std::sync::Arc;

use eframe::egui::text::{LayoutJob, TextWrapping};
use eframe::egui::{
    Align2, Color32, FontId, Galley, Id, Painter, Pos2, Rect, Response, Role, Sense, Shape, Stroke,
    StrokeKind, Ui, WidgetInfo, pos2, vec2,
};

use crate::style::{self, Style};
use jde_panel::Ink;
use jde_timeline::{MarkKind, Severity};

/// Height of a row, in points: a line of text, and enough for a button.
pub(super) const ROW: f32 = 22.0;
/// Font size of a row's text.
const TEXT_SIZE: f32 = 12.5;
/// The least letters of a name that are of use, with the sign that it is cut: "…_path".
const LEAST_LETTERS: f32 = 6.0;
/// About the width of a letter of a row, in points.
pub(super) const LETTER: f32 = 6.5;

pub(super) fn font() -> FontId {
    FontId::proportional(TEXT_SIZE)
}

pub(super) fn small() -> FontId {
    FontId::proportional(TEXT_SIZE - 2.0)
}

pub(super) fn digits() -> FontId {
    FontId::monospace(TEXT_SIZE - 1.0)
}

/// Lays out one line of text, truncated to a width and marked where cut.
pub(super) fn cut(painter: &Painter, text: &str, font: FontId, color: Color32, width: f32) -> Arc<Galley> {
    let mut job = LayoutJob::simple_singleline(text.to_owned(), font, color);
    job.wrap = TextWrapping::truncate_at_width(width.max(0.0));
    painter.layout_job(job)
}

/// Writes one line into a rectangle, vertically centered. Returns its right end.
pub(super) fn write(painter: &Painter, rect: Rect, text: &str, font: FontId, color: Color32) -> f32 {
    if rect.width() < 4.0 {
        return rect.left();
    }
    let galley = cut(painter, text, font, color, rect.width());
    let at = pos2(rect.left(), rect.center().y - galley.size().y / 2.0);
    let end = rect.left() + galley.size().x;
    painter.galley(at, galley, color);
    end
}

/// Writes a name as [`write`] does. Of a name that is too long it keeps the end, which is more specific than
/// the beginning.
pub(super) fn write_name(painter: &Painter, rect: Rect, name: &str, font: FontId, color: Color32) -> f32 {
    let width = |text: &str| {
        let galley = painter.layout_no_wrap(text.to_owned(), font.clone(), color);
        galley.size().x
    };
    let shown = tail(name, |text| width(text) <= rect.width());
    write(painter, rect, &shown, font, color)
}

/// Writes a name as [`write_name`] does, and nothing where less than [`LEAST_LETTERS`] of a longer one would be left.
pub(super) fn write_if_readable(painter: &Painter, rect: Rect, name: &str, font: FontId, color: Color32) {
    let galley = painter.layout_no_wrap(name.to_owned(), font.clone(), color);
    if galley.size().x <= rect.width() || rect.width() >= LEAST_LETTERS * LETTER {
        write_name(painter, rect, name, font, color);
    }
}

/// Returns a name that fits: whole, or its end after an ellipsis. The end begins with a whole part of the
/// name unless that shows less than half of the letters that fit.
fn tail(name: &str, fits: impl Fn(&str) -> bool) -> String {
    if fits(name) {
        return name.to_owned();
    }
    let end = |start: usize| format!("…{}", &name[start..]);
    let starts: Vec<usize> = name.char_indices().skip(1).map(|(start, _)| start).collect();
    let longest = starts.partition_point(|start| !fits(&end(*start)));
    let fitting = &starts[longest..];
    let mut candidates = fitting.iter().take(fitting.len().div_ceil(2));
    let part = candidates.find(|start| name[..**start].ends_with(['/', '.']));
    part.or(fitting.first())
        .map_or_else(|| "…".to_owned(), |start| end(*start))
}

/// Writes a number aligned to the right edge.
pub(super) fn write_right(painter: &Painter, rect: Rect, text: &str, color: Color32) {
    painter.text(rect.right_center(), Align2::RIGHT_CENTER, text, digits(), color);
}

/// The sign on a button.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Icon {
    Fold,
    Unfold,
    Remove,
}

/// Shows a button with a drawn sign. Tests and screen readers find it by its name.
pub(super) fn button(
    ui: &Ui,
    rect: Rect,
    id: Id,
    icon: Icon,
    (name, tip): (&str, &str),
    (enabled, pressed): (bool, bool),
) -> Response {
    let sense = if enabled { Sense::click() } else { Sense::hover() };
    let response = ui.interact(rect, id, sense);
    response.widget_info(|| WidgetInfo::selected(Role::Button, enabled, pressed, name));
    let visuals = ui.style().interact_selectable(&response, pressed);
    let painter = ui.painter();
    if enabled && (pressed || response.hovered() || response.has_focus()) {
        painter.rect(
            rect.shrink(1.0),
            3.0,
            visuals.weak_bg_fill,
            if response.has_focus() {
                ui.visuals().selection.stroke
            } else {
                Stroke::NONE
            },
            StrokeKind::Inside,
        );
    }
    let color = if enabled {
        visuals.fg_stroke.color
    } else {
        ui.visuals().weak_text_color().gamma_multiply(0.5)
    };
    paint(painter, rect.center(), icon, color);
    if response.hovered() {
        response.clone().on_hover_text(tip);
    }
    response
}

fn paint(painter: &Painter, at: Pos2, icon: Icon, color: Color32) {
    let line = Stroke::new(1.4, color);
    let triangle = |corners: [(f32, f32); 3]| {
        Shape::convex_polygon(
            corners.map(|(x, y)| at + vec2(x, y)).to_vec(),
            color,
            Stroke::NONE,
        )
    };
    match icon {
        Icon::Fold => {
            painter.add(triangle([(-4.0, -2.5), (4.0, -2.5), (0.0, 3.0)]));
        }
        Icon::Unfold => {
            painter.add(triangle([(-2.5, -4.0), (3.0, 0.0), (-2.5, 4.0)]));
        }
        Icon::Remove => {
            painter.line_segment([at + vec2(-3.5, -3.5), at + vec2(3.5, 3.5)], line);
            painter.line_segment([at + vec2(-3.5, 3.5), at + vec2(3.5, -3.5)], line);
        }
    }
}

/// The color of an event.
pub(super) fn mark(kind: MarkKind, style: &Style) -> Color32 {
    let color = match (kind, kind.severity()) {
        (MarkKind::Operator | MarkKind::Reloaded, _) => Ink::Goal,
        (MarkKind::Refused | MarkKind::Limited, _) => Ink::Seen,
        (_, Severity::Good) => Ink::Good,
        (_, Severity::Warning) => Ink::Warn,
        (_, Severity::Bad) => Ink::Bad,
    };
    style::color_of(color, style)
}

/// The color of a signal. Signals also differ in position and name.
pub(super) fn signal_color(place: usize, style: &Style) -> Color32 {
    let inks = [Ink::Accent, Ink::Warn, Ink::Good, Ink::Goal, Ink::Seen, Ink::Bad];
    style::color_of(inks[place % inks.len()], style)
}

#[cfg(test)]
mod tests {
    use super::tail;

    #[test]
    fn a_long_name_keeps_its_end() {
        let cut = |name: &str, columns: usize| tail(name, |text| text.chars().count() <= columns);
        assert_eq!(cut("example/base", 12), "example/base");
        assert_eq!(cut("safe-navigation/example/base", 16), "…example/base");
        assert_eq!(cut("safe-navigation/example/base", 9), "…ple/base");
        assert_eq!(cut("pioneer.odometry.pose.x", 10), "…pose.x");
        assert_eq!(cut("Überschrift", 4), "…ift");
        assert_eq!(cut("goon", 1), "…");
    }
}
