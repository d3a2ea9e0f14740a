//! What is written and drawn over the picture: names at their places, ticks of the grid, the axes in a corner.

use eframe::egui::{self, Align2, Color32, FontId, Painter, Pos2, Rect, Stroke, vec2};
use glam::{Vec2, Vec3};
use jde_panel::Ink;

use super::compose::axis_colors;
use super::draw_list::DrawList;
use super::orbit::Eye;
use crate::style::{Style, color_of};

/// Room around the letters of a label.
const ROOM: egui::Vec2 = vec2(4.0, 1.5);
/// How far the axes of the corner reach, points.
const GIZMO: f32 = 30.0;
/// Ticks on one side of an axis.
const TICKS: i32 = 20;

/// From line to line of the grid, m, so that lines are neither crowded nor lost: a power of ten.
pub(crate) fn step(distance: f32) -> f32 {
    10_f32
        .powf((distance / 25.0).max(0.05).log10().ceil())
        .clamp(0.1, 100.0)
}

/// The labels of a stage, near ones over far ones.
pub(crate) fn labels(painter: &Painter, rect: Rect, eye: &Eye, draw_list: &DrawList, style: &Style) {
    let mut order: Vec<_> = draw_list.labels.iter().collect();
    order.sort_by(|a, b| {
        let far = |at: Vec3| at.distance_squared(eye.place);
        far(b.at).total_cmp(&far(a.at))
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

/// How far it is along the axes of the floor.
pub(crate) fn ticks(painter: &Painter, rect: Rect, eye: &Eye, step: f32, style: &Style) {
    let faint = color_of(Ink::Faint, style);
    let mut last: [Option<Pos2>; 2] = [None; 2];
    for number in (-TICKS..=TICKS).filter(|number| *number != 0) {
        for axis in 0..2 {
            let mut place = Vec3::ZERO;
            place[axis] = number as f32 * step;
            // Where the floor fades nobody reads them.
            if place.distance(eye.target) > 2.5 * eye.distance {
                continue;
            }
            let Some(at) = on_screen(rect, eye, place) else {
                continue;
            };
            // None on top of the last: what is far is close together.
            if last[axis].is_some_and(|last| last.distance(at) < 44.0) {
                continue;
            }
            last[axis] = Some(at);
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

/// Which way x, y and z point, in the lower right corner.
pub(crate) fn gizmo(painter: &Painter, rect: Rect, eye: &Eye, style: &Style) {
    let middle = rect.right_bottom() - vec2(GIZMO + 16.0, GIZMO + 16.0);
    let ground = if style.dark {
        Color32::from_black_alpha(70)
    } else {
        Color32::from_white_alpha(120)
    };
    painter.circle_filled(middle, GIZMO + 11.0, ground);
    let back = eye.right.cross(eye.up);
    let mut axes: Vec<_> = Vec3::AXES
        .into_iter()
        .zip(axis_colors(style))
        .zip(["x", "y", "z"])
        .collect();
    axes.sort_by(|((a, _), _), ((b, _), _)| a.dot(back).total_cmp(&b.dot(back)));
    for ((axis, color), name) in axes {
        let tip = middle + vec2(axis.dot(eye.right), -axis.dot(eye.up)) * GIZMO;
        painter.line_segment([middle, tip], Stroke::new(2.5, color));
        painter.circle_filled(tip, 7.5, color);
        let color = if style.dark {
            Color32::BLACK
        } else {
            Color32::WHITE
        };
        painter.text(
            tip,
            Align2::CENTER_CENTER,
            name,
            FontId::proportional(11.0),
            color,
        );
    }
}

/// A text on a ground that keeps it readable.
pub(crate) fn plate(painter: &Painter, at: Pos2, align: Align2, text: &str, color: Color32, style: &Style) {
    let ground = if style.dark {
        Color32::from_black_alpha(150)
    } else {
        Color32::from_white_alpha(190)
    };
    let galley = painter.layout_no_wrap(text.to_owned(), FontId::proportional(12.0), color);
    let rect = align.anchor_size(at, galley.size() + 2.0 * ROOM);
    painter.rect_filled(rect, 3.0, ground);
    painter.galley(rect.min + ROOM, galley, color);
}

fn on_screen(rect: Rect, eye: &Eye, at: Vec3) -> Option<Pos2> {
    let Vec2 { x, y } = eye.project(at)?;
    let at = rect.min + vec2(x, y);
    rect.expand(20.0).contains(at).then_some(at)
}
