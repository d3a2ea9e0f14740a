//! Pans and zooms a plane by drag, wheel, pinch and keys, except for gestures that the plane's owner
//! requested.

use eframe::egui::{self, Key, Rect, Response, Ui, Vec2, vec2};

use super::{Canvas, View, gestures};

/// Distance that an arrow key moves the plane, in points of the screen.
const KEY_DISTANCE: f32 = 40.0;
/// Factor by which + and - zoom.
const KEY_ZOOM: f64 = 1.25;
/// Points of the wheel that zoom by a factor of e.
const WHEEL_PER_E: f64 = 240.0;

/// Moves the view by this frame's input.
pub(super) fn steer(ui: &Ui, response: &Response, rect: Rect, view: &mut View, canvas: &Canvas<'_>) {
    if let Some(pointer) = response.hover_pos() {
        let (scroll, pinch) = ui.input(|input| (input.smooth_scroll_delta.y, input.zoom_delta()));
        let factor = f64::from(pinch) * (f64::from(scroll) / WHEEL_PER_E).exp();
        if factor != 1.0 {
            view.zoom(rect, canvas.home, canvas.forward_up, pointer, factor);
            // Otherwise the surrounding area would scroll too.
            ui.ctx().input_mut(|input| input.smooth_scroll_delta = Vec2::ZERO);
        }
    }
    if response.dragged() && !view.gestures.drags() && response.drag_delta() != Vec2::ZERO {
        view.pan(rect, canvas.home, canvas.forward_up, response.drag_delta());
    }
    if !canvas.wants.clicks && response.double_clicked() {
        view.fit();
    }
    if response.has_focus() && !canvas.wants.keys {
        for event in gestures::keys(ui, response) {
            if let egui::Event::Key {
                key, pressed: true, ..
            } = event
            {
                press(key, rect, view, canvas);
            }
        }
    }
}

fn press(key: Key, rect: Rect, view: &mut View, canvas: &Canvas<'_>) {
    let pan = |view: &mut View, x: f32, y: f32| {
        view.pan(rect, canvas.home, canvas.forward_up, vec2(x, y) * KEY_DISTANCE);
    };
    let middle = rect.center();
    match key {
        Key::ArrowLeft => pan(view, 1.0, 0.0),
        Key::ArrowRight => pan(view, -1.0, 0.0),
        Key::ArrowUp => pan(view, 0.0, 1.0),
        Key::ArrowDown => pan(view, 0.0, -1.0),
        Key::Plus | Key::Equals => view.zoom(rect, canvas.home, canvas.forward_up, middle, KEY_ZOOM),
        Key::Minus => view.zoom(rect, canvas.home, canvas.forward_up, middle, 1.0 / KEY_ZOOM),
        Key::Num0 | Key::Home => view.fit(),
        _ => {}
    }
}
