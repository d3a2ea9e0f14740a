//! Gestures on a plane or image that its owner requested. Each drag is ended, and each pressed key is
//! released, even if the focus is lost.

use eframe::egui::{self, EventFilter, Key, PointerButton, Pos2, Response, Ui, Vec2};
use jde_panel::{Button, Touch, Wants};

const BUTTONS: [(PointerButton, Button); 3] = [
    (PointerButton::Primary, Button::Primary),
    (PointerButton::Secondary, Button::Secondary),
    (PointerButton::Middle, Button::Middle),
];

/// Gestures in progress, kept from frame to frame.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Gestures {
    /// The drag in progress: its start and its button.
    drag: Option<([f64; 3], Button)>,
    /// Keys reported as pressed and not yet as released.
    down: Vec<String>,
}

impl Gestures {
    /// Whether a reported drag is in progress. The view then does not pan.
    pub(crate) fn drags(&self) -> bool {
        self.drag.is_some()
    }

    /// The requested gestures of this frame: drags, then clicks, then keys. `place` maps a point of the
    /// screen to a position.
    pub(crate) fn touches(
        &mut self,
        ui: &Ui,
        response: &Response,
        wants: Wants,
        place: impl Fn(Pos2) -> [f64; 3],
    ) -> Vec<Touch> {
        let mut touches = Vec::new();
        if response.clicked() || response.drag_started() {
            response.request_focus();
        }
        self.drag(ui, response, wants, &place, &mut touches);
        for (pointer_button, button) in BUTTONS {
            if wants.clicks
                && response.clicked_by(pointer_button)
                && let Some(at) = response.interact_pointer_pos()
            {
                let at = place(at);
                touches.push(Touch::Clicked { at, button });
            }
        }
        self.keys(ui, response, wants, &mut touches);
        touches
    }

    fn drag(
        &mut self,
        ui: &Ui,
        response: &Response,
        wants: Wants,
        place: &impl Fn(Pos2) -> [f64; 3],
        touches: &mut Vec<Touch>,
    ) {
        if response.drag_started() && wants.drags {
            let (origin, shift) = ui.input(|input| (input.pointer.press_origin(), input.modifiers.shift));
            let dragged_with = BUTTONS
                .into_iter()
                .find(|(button, _)| response.dragged_by(*button));
            // The middle button and Shift always pan the view.
            if let (Some(origin), Some((_, button)), false) = (origin, dragged_with, shift)
                && button != Button::Middle
            {
                self.drag = Some((place(origin), button));
            }
        }
        let Some((from, button)) = self.drag else { return };
        let pointer = response
            .interact_pointer_pos()
            .or_else(|| ui.input(|input| input.pointer.latest_pos()));
        let ended = !response.dragged();
        if ended || response.drag_started() || response.drag_delta() != Vec2::ZERO {
            touches.push(Touch::Dragged {
                from,
                to: pointer.map_or(from, place),
                button,
                ended,
            });
        }
        if ended {
            self.drag = None;
        }
    }

    fn keys(&mut self, ui: &Ui, response: &Response, wants: Wants, touches: &mut Vec<Touch>) {
        let focused = response.has_focus() && ui.input(|input| input.focused);
        if !focused || !wants.keys {
            touches.extend(self.down.drain(..).map(|key| Touch::Key { key, down: false }));
            return;
        }
        for event in keys(ui, response) {
            let egui::Event::Key {
                key,
                pressed,
                repeat,
                modifiers,
                ..
            } = event
            else {
                continue;
            };
            let key = name(key);
            match (pressed, self.down.iter().position(|down| *down == key)) {
                (true, None) if !repeat && !modifiers.command => self.down.push(key.clone()),
                (false, Some(place)) => drop(self.down.remove(place)),
                _ => continue,
            }
            touches.push(Touch::Key { key, down: pressed });
        }
    }
}

/// The key events of this frame for the focused widget. The arrow keys do not move the focus.
pub(super) fn keys(ui: &Ui, response: &Response) -> Vec<egui::Event> {
    let filter = EventFilter {
        horizontal_arrows: true,
        vertical_arrows: true,
        ..EventFilter::default()
    };
    ui.memory_mut(|memory| memory.set_focus_lock_filter(response.id, filter));
    ui.input(|input| input.filtered_events(&filter))
}

/// The name of a key in gestures: `a`, `1`, `Space`, `ArrowUp`.
fn name(key: Key) -> String {
    let name = format!("{key:?}");
    match name.strip_prefix("Num") {
        Some(digit) if digit.len() == 1 => digit.to_owned(),
        _ if name.len() == 1 => name.to_lowercase(),
        _ => name,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_have_their_gesture_names() {
        let names = [Key::A, Key::Num7, Key::Space, Key::ArrowUp, Key::F5].map(name);
        assert_eq!(names, ["a", "7", "Space", "ArrowUp", "F5"]);
    }
}
