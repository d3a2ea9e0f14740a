//! A square pad that springs back. It reads two axes from the mouse, or from keys while it has the focus. It
//! sends no commands.

use eframe::egui::{
    self, Align2, CursorIcon, EventFilter, FontId, Key, PointerButton, Pos2, Rect, Response, Sense, Stroke,
    StrokeKind, Ui, Vec2, WidgetInfo, vec2,
};
use jde_panel::Ink;

use crate::style::{self, Style};
use crate::tap::tap;

/// Fraction of a deflection that counts as none.
const DEAD_ZONE: f32 = 0.06;
/// The keys of each direction: right, left, up, down.
const KEYS: [(Vec2, [Key; 2]); 4] = [
    (vec2(1.0, 0.0), [Key::ArrowRight, Key::D]),
    (vec2(-1.0, 0.0), [Key::ArrowLeft, Key::A]),
    (vec2(0.0, 1.0), [Key::ArrowUp, Key::W]),
    (vec2(0.0, -1.0), [Key::ArrowDown, Key::S]),
];

/// A pad.
pub(super) struct Pad<'a> {
    /// The accessible name.
    pub(super) name: &'a str,
    /// Labels of the directions right, left, up and down.
    pub(super) labels: [&'a str; 4],
    /// Length of a side, in points.
    pub(super) side: f32,
}

impl Pad<'_> {
    /// Shows the pad. Returns its deflection while the user holds it: each axis from -1 to 1, x to the right
    /// and y up. Returns `None` otherwise, and if the window lacks the focus.
    pub(super) fn show(&self, ui: &mut Ui, style: &Style) -> Option<Vec2> {
        let (rect, response) = ui.allocate_exact_size(Vec2::splat(self.side), Sense::drag());
        let response = response
            .on_hover_cursor(CursorIcon::Grab)
            .on_hover_text("Drag, or arrow keys or WASD while it has the focus; Space holds the robot still");
        let enabled = ui.is_enabled();
        response.widget_info(|| WidgetInfo::labeled(egui::Role::Canvas, enabled, self.name));
        let deflection = if enabled {
            self.deflection(ui, rect, &response)
        } else {
            None
        };
        if ui.is_rect_visible(rect) {
            self.paint(ui, rect, &response, deflection, style);
        }
        deflection
    }

    fn deflection(&self, ui: &Ui, rect: Rect, response: &Response) -> Option<Vec2> {
        if !ui.input(|input| input.focused) {
            return None;
        }
        if response.drag_started() || tap(ui, response).is_some() {
            response.request_focus();
        }
        if response.dragged_by(PointerButton::Primary)
            && let Some(at) = response.interact_pointer_pos()
        {
            let push = (at - rect.center()) / (0.5 * self.side);
            return Some(vec2(axis(push.x), axis(-push.y)));
        }
        if !response.has_focus() {
            return None;
        }
        // The arrow keys push the pad and do not move the focus.
        let filter = EventFilter {
            horizontal_arrows: true,
            vertical_arrows: true,
            ..EventFilter::default()
        };
        ui.memory_mut(|memory| memory.set_focus_lock_filter(response.id, filter));
        ui.input(|input| {
            if input.key_down(Key::Space) {
                return Some(Vec2::ZERO);
            }
            let down = KEYS
                .iter()
                .filter(|(_, keys)| keys.iter().any(|key| input.key_down(*key)));
            let pushes: Vec<Vec2> = down.map(|(push, _)| *push).collect();
            (!pushes.is_empty()).then(|| pushes.into_iter().fold(Vec2::ZERO, |sum, push| sum + push))
        })
    }

    fn paint(&self, ui: &Ui, rect: Rect, response: &Response, deflection: Option<Vec2>, style: &Style) {
        let visuals = ui.visuals();
        let painter = ui.painter();
        let faint = style::color_of(Ink::Faint, style);
        let edge = if response.has_focus() {
            visuals.selection.stroke
        } else {
            Stroke::new(1.0, faint)
        };
        painter.rect(rect, 8.0, visuals.extreme_bg_color, edge, StrokeKind::Inside);
        let middle = rect.center();
        let grid = Stroke::new(1.0, faint.gamma_multiply(0.5));
        painter.hline(rect.shrink(8.0).x_range(), middle.y, grid);
        painter.vline(middle.x, rect.shrink(8.0).y_range(), grid);
        painter.circle_stroke(middle, 0.25 * self.side, grid);
        let font = FontId::proportional(10.5);
        let [right, left, up, down] = self.labels;
        for (at, align, text) in [
            (
                rect.right_center() + vec2(-6.0, -8.0),
                Align2::RIGHT_CENTER,
                right,
            ),
            (rect.left_center() + vec2(6.0, -8.0), Align2::LEFT_CENTER, left),
            (rect.center_top() + vec2(0.0, 6.0), Align2::CENTER_TOP, up),
            (
                rect.center_bottom() + vec2(0.0, -6.0),
                Align2::CENTER_BOTTOM,
                down,
            ),
        ] {
            painter.text(at, align, text, font.clone(), faint);
        }
        let push = deflection.unwrap_or_default();
        let thumb: Pos2 = middle + vec2(push.x, -push.y) * (0.5 * self.side - 12.0);
        if deflection.is_some() {
            let color = style::color_of(Ink::Accent, style);
            painter.line_segment([middle, thumb], Stroke::new(2.0, color));
            painter.circle_filled(thumb, 12.0, color);
        } else {
            let ground = visuals.widgets.inactive.bg_fill;
            painter.circle(thumb, 12.0, ground, Stroke::new(1.5, faint));
        }
    }
}

/// Limits an axis to -1 to 1, with a dead zone around 0.
fn axis(push: f32) -> f32 {
    let push = push.clamp(-1.0, 1.0);
    if push.abs() < DEAD_ZONE { 0.0 } else { push }
}
