//! Game pads: while a shoulder button is held, the sticks act as the pads of the window. It sends no
//! commands.

use eframe::egui::{Ui, Vec2, vec2};
use gilrs::{Axis, Button, Gamepad, Gilrs};

use super::Sticks;
use super::lease::BEAT;

/// Fraction of a stick's travel below which it is at rest.
const DEAD: f32 = 0.12;

/// The game pads of this machine.
pub(super) struct Gamepads {
    gilrs: Result<Gilrs, String>,
}

impl Default for Gamepads {
    fn default() -> Self {
        Self {
            gilrs: Gilrs::new().map_err(|error| error.to_string()),
        }
    }
}

impl Gamepads {
    /// Shows the status of the game pads, and returns the positions of their sticks. Call in each frame.
    pub(super) fn sticks(&mut self, ui: &mut Ui) -> Sticks {
        let sticks = self.held();
        ui.weak(self.status());
        if self.any() {
            ui.ctx().request_repaint_after(BEAT);
        }
        let focused = ui.input(|input| input.focused);
        sticks.filter(|_| focused).unwrap_or_default()
    }

    /// Processes the pending events. Returns the sticks of the first pad with a held shoulder button.
    fn held(&mut self) -> Option<Sticks> {
        let gilrs = self.gilrs.as_mut().ok()?;
        while gilrs.next_event().is_some() {}
        let held =
            |pad: &Gamepad<'_>| pad.is_pressed(Button::LeftTrigger) || pad.is_pressed(Button::RightTrigger);
        let (_, pad) = gilrs.gamepads().find(|(_, pad)| held(pad))?;
        let stick = |x: Axis, y: Axis| without_dead_zone(vec2(pad.value(x), pad.value(y)));
        Some(Sticks {
            drive: Some(stick(Axis::LeftStickX, Axis::LeftStickY)),
            head: Some(stick(Axis::RightStickX, Axis::RightStickY)),
        })
    }

    /// Whether a game pad is connected, so that it must be polled.
    fn any(&self) -> bool {
        self.gilrs
            .as_ref()
            .is_ok_and(|gilrs| gilrs.gamepads().next().is_some())
    }

    /// The status of the game pads, as text.
    fn status(&self) -> String {
        match &self.gilrs {
            Err(reason) => format!("no game pads: {reason}"),
            Ok(gilrs) => match gilrs.gamepads().next() {
                None => "no game pad is connected".to_owned(),
                Some((_, pad)) => format!("{}: hold a shoulder button and push a stick", pad.name()),
            },
        }
    }
}

/// Rescales a stick's position: from 0 at the edge of the dead zone to at most 1.
fn without_dead_zone(push: Vec2) -> Vec2 {
    let length = push.length();
    if length < DEAD {
        return Vec2::ZERO;
    }
    push / length * ((length - DEAD) / (1.0 - DEAD)).min(1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_stick_has_a_dead_zone_and_full_deflection_at_its_edge() {
        assert_eq!(without_dead_zone(vec2(0.05, -0.1)), Vec2::ZERO);
        assert!((without_dead_zone(vec2(0.0, 1.0)) - vec2(0.0, 1.0)).length() < 1e-6);
        assert!(
            without_dead_zone(vec2(0.13, 0.0)).length() < 0.02,
            "no jump at the edge of the dead zone"
        );
        assert!(
            (without_dead_zone(vec2(1.0, 1.0)).length() - 1.0).abs() < 1e-6,
            "a corner is not faster"
        );
    }
}
