//! The grid of a plane: lines at round distances, numbers at the edges, a scale bar, and the position under
//! the pointer.

use eframe::egui::{Align2, FontId, Painter, Pos2, Stroke, pos2, vec2};
use jde_panel::Ink;

use super::Transform;
use crate::style::{self, Style};

/// Minimum distance of numbered lines, in points of the screen.
const MIN_NUMBER_DISTANCE: f64 = 56.0;
/// Minimum distance of lines, in points of the screen.
const MIN_LINE_DISTANCE: f64 = 11.0;
const FONT_SIZE: f32 = 10.0;

/// Draws the grid over the visible area.
pub(super) fn draw(painter: &Painter, transform: &Transform, style: &Style) {
    let color = style::color_of(Ink::Faint, style);
    let coarse = step(MIN_NUMBER_DISTANCE / transform.scale());
    let fine = [coarse / 10.0, coarse / 5.0, coarse / 2.0]
        .into_iter()
        .find(|fine| fine * transform.scale() >= MIN_LINE_DISTANCE);
    if let Some(fine) = fine {
        lines(
            painter,
            transform,
            fine,
            Stroke::new(1.0, color.gamma_multiply(0.13)),
        );
    }
    lines(
        painter,
        transform,
        coarse,
        Stroke::new(1.0, color.gamma_multiply(0.28)),
    );
    let origin = transform.screen([0.0, 0.0]);
    let rect = transform.rect();
    let axis = Stroke::new(1.0, color.gamma_multiply(0.7));
    painter.vline(origin.x, rect.y_range(), axis);
    painter.hline(rect.x_range(), origin.y, axis);
    numbers(painter, transform, coarse, style);
    scale(painter, transform, coarse, style);
}

/// Writes the position under the pointer in the lower left corner.
pub(super) fn pointer_position(painter: &Painter, transform: &Transform, pointer: Pos2, style: &Style) {
    let [x, y] = transform.plane(pointer);
    let (x, unit) = style.units.convert(x, "m");
    let (y, _) = style.units.convert(y, "m");
    let digits = if unit == "m" { 2 } else { 0 };
    let text = format!("x {x:.digits$} {unit}   y {y:.digits$} {unit}");
    let at = transform.rect().left_bottom() + vec2(30.0, -18.0);
    write(painter, at, Align2::LEFT_BOTTOM, &text, style, Ink::Plain);
}

/// The smallest 1, 2 or 5 times a power of ten that is not less than `least`.
fn step(least: f64) -> f64 {
    let power = 10_f64.powf(least.log10().floor());
    [1.0, 2.0, 5.0, 10.0]
        .into_iter()
        .map(|factor| factor * power)
        .find(|step| *step >= least * 0.999_999)
        .unwrap_or(10.0 * power)
}

/// The visible multiples of a step along an axis of the plane.
fn multiples(transform: &Transform, axis: usize, step: f64) -> impl Iterator<Item = f64> {
    let area = transform.area();
    let (first, last) = (
        (area.least[axis] / step).ceil(),
        (area.greatest[axis] / step).floor(),
    );
    // Bounds the loop: no screen shows this many lines.
    let count = (last - first).clamp(-1.0, 2000.0) as i64;
    (0..=count).map(move |number| (first + number as f64) * step)
}

fn lines(painter: &Painter, transform: &Transform, step: f64, stroke: Stroke) {
    let rect = transform.rect();
    for axis in 0..2 {
        for at in multiples(transform, axis, step) {
            let mut place = [0.0, 0.0];
            place[axis] = at;
            let screen = transform.screen(place);
            if (axis == 0) == transform.forward_up() {
                painter.hline(rect.x_range(), screen.y, stroke);
            } else {
                painter.vline(screen.x, rect.y_range(), stroke);
            }
        }
    }
}

fn numbers(painter: &Painter, transform: &Transform, step: f64, style: &Style) {
    let rect = transform.rect();
    for axis in 0..2 {
        for at in multiples(transform, axis, step) {
            let mut place = [0.0, 0.0];
            place[axis] = at;
            let screen = transform.screen(place);
            let text = number(at, step, style);
            let (at, align) = if (axis == 0) == transform.forward_up() {
                (pos2(rect.left() + 4.0, screen.y), Align2::LEFT_CENTER)
            } else {
                (pos2(screen.x, rect.bottom() - 3.0), Align2::CENTER_BOTTOM)
            };
            // Keeps the corner and the area of the scale bar free.
            let visible = rect.shrink2(vec2(0.0, 16.0));
            let free = match align {
                Align2::LEFT_CENTER => visible.y_range().contains(at.y),
                _ => at.x > rect.left() + 40.0 && at.x < rect.right() - 90.0,
            };
            if free {
                write(painter, at, align, &text, style, Ink::Faint);
            }
        }
    }
}

/// Draws the scale bar: the length of a step.
fn scale(painter: &Painter, transform: &Transform, step: f64, style: &Style) {
    let rect = transform.rect();
    let length = (step * transform.scale()) as f32;
    if length > rect.width() * 0.5 {
        return;
    }
    let right = rect.right_bottom() + vec2(-8.0, -6.0);
    let left = right - vec2(length, 0.0);
    let stroke = Stroke::new(1.5, style::color_of(Ink::Faint, style));
    painter.line_segment([left, right], stroke);
    for end in [left, right] {
        painter.line_segment([end, end - vec2(0.0, 4.0)], stroke);
    }
    let (_, unit) = style.units.convert(step, "m");
    let text = format!("{} {unit}", number(step, step, style));
    let middle = left.lerp(right, 0.5) - vec2(0.0, 3.0);
    write(painter, middle, Align2::CENTER_BOTTOM, &text, style, Ink::Faint);
}

/// Formats a multiple of a step with as many digits as the step has.
fn number(at: f64, step: f64, style: &Style) -> String {
    let (at, _) = style.units.convert(at, "m");
    let (step, _) = style.units.convert(step, "m");
    let digits = (-step.log10().floor()).clamp(0.0, 6.0) as usize;
    // Avoids "-0".
    format!("{:.digits$}", if at == 0.0 { 0.0 } else { at })
}

fn write(painter: &Painter, at: Pos2, align: Align2, text: &str, style: &Style, color: Ink) {
    painter.text(
        at,
        align,
        text,
        FontId::proportional(FONT_SIZE),
        style::color_of(color, style),
    );
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_step_is_a_round_distance() {
        for (least, expected) in [
            (0.7, 1.0),
            (1.0, 1.0),
            (1.1, 2.0),
            (3.0, 5.0),
            (0.051, 0.1),
            (700.0, 1000.0),
        ] {
            let step = step(least);
            assert!((step - expected).abs() < 1e-9 * expected, "{least} gives {step}");
        }
    }
}
