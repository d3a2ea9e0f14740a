//! Text and signs over the picture: labels at their positions, ticks of the grid, and the axes in a corner.

use eframe::egui::{self, Align2, Color32, FontId, Painter, Pos2, Rect, Stroke, vec2};
use glam::{Vec2, Vec3};
use jde_panel::Ink;

use super::compose::axis_colors;
use super::draw_list::DrawList;
use super::orbit::Eye;
use crate::style::{Style, color_of, text_on};

/// Margin around the text of a label.
const PADDING: egui::Vec2 = vec2(4.0, 1.5);
/// Length of the axes in the corner, in points.
const GIZMO_LENGTH: f32 = 30.0;
/// Number of ticks on each side of an axis.
const TICKS_PER_SIDE: i32 = 20;

/// The distance of the grid's lines, in m: a power of ten that suits the distance of the eye.
pub(crate) fn step(distance: f32) -> f32 {
    10_f32
        .powf((distance / 25.0).max(0.05).log10().ceil())
        .clamp(0.1, 100.0)
}

/// Draws the labels of a draw list, near ones over far ones.
pub(crate) fn labels(painter: &Painter, rect: Rect, eye: &Eye, draw_list: &DrawList, style: &Style) {
    let mut order: Vec<_> = draw_list.labels.iter().collect();
    order.sort_by(|a, b| {
        let distance = |at: Vec3| at.distance_squared(eye.place);
        distance(b.at).total_cmp(&distance(a.at))
    });
    for label in order {
        if let Some(at) = on_screen(rect, eye, label.at) {
            plate(
                painter,
                at,
                Align2::CENTER_BOTTOM,
                &label.text,
                label.color,
                style,
            );
        }
    }
}

/// Draws the distances along the axes of the floor.
pub(crate) fn ticks(painter: &Painter, rect: Rect, eye: &Eye, step: f32, style: &Style) {
    let faint = color_of(Ink::Faint, style);
    let mut previous: [Option<Pos2>; 2] = [None; 2];
    for number in (-TICKS_PER_SIDE..=TICKS_PER_SIDE).filter(|number| *number != 0) {
        for axis in 0..2 {
            let mut place = Vec3::ZERO;
            place[axis] = number as f32 * step;
            // The floor fades out there.
            if place.distance(eye.target) > 2.5 * eye.distance {
                continue;
            }
            let Some(at) = on_screen(rect, eye, place) else {
                continue;
            };
            // Skips ticks that would overlap the last one.
            if previous[axis].is_some_and(|previous| previous.distance(at) < 44.0) {
                continue;
            }
            previous[axis] = Some(at);
            let text = style.units.show(f64::from(place[axis]), "m");
            painter.text(
                at + vec2(3.0, 2.0),
                Align2::LEFT_TOP,
                text,
                FontId::proportional(10.0),
                faint,
            );
        }
    }
}

/// Draws the directions of x, y and z in the lower right corner.
pub(crate) fn gizmo(painter: &Painter, rect: Rect, eye: &Eye, style: &Style) {
    let middle = rect.right_bottom() - vec2(GIZMO_LENGTH + 16.0, GIZMO_LENGTH + 16.0);
    let ground = if style.dark {
        Color32::from_black_alpha(70)
    } else {
        Color32::from_white_alpha(120)
    };
    painter.circle_filled(middle, GIZMO_LENGTH + 11.0, ground);
    let back = eye.right.cross(eye.up);
    let mut axes: Vec<_> = Vec3::AXES
        .into_iter()
        .zip(axis_colors(style))
        .zip(["x", "y", "z"])
        .collect();
    axes.sort_by(|((a, _), _), ((b, _), _)| a.dot(back).total_cmp(&b.dot(back)));
    for ((axis, color), name) in axes {
        let tip = middle + vec2(axis.dot(eye.right), -axis.dot(eye.up)) * GIZMO_LENGTH;
        painter.line_segment([middle, tip], Stroke::new(2.5, color));
        painter.circle_filled(tip, 7.5, color);
        let color = text_on(color);
        painter.text(
            tip,
            Align2::CENTER_CENTER,
            name,
            FontId::proportional(11.0),
            color,
        );
    }
}

/// Draws a text on a background that keeps it readable.
pub(crate) fn plate(painter: &Painter, at: Pos2, align: Align2, text: &str, color: Color32, style: &Style) {
    let ground = if style.dark {
        Color32::from_black_alpha(200)
    } else {
        Color32::from_white_alpha(225)
    };
    let galley = painter.layout_no_wrap(text.to_owned(), FontId::proportional(12.0), color);
    let rect = align.anchor_size(at, galley.size() + 2.0 * PADDING);
    painter.rect_filled(rect, 3.0, ground);
    painter.galley(rect.min + PADDING, galley, color);
}

fn on_screen(rect: Rect, eye: &Eye, at: Vec3) -> Option<Pos2> {
    let Vec2 { x, y } = eye.project(at)?;
    let at = rect.min + vec2(x, y);
    rect.expand(20.0).contains(at).then_some(at)
}
