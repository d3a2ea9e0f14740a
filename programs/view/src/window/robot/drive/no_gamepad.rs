//! In a build without the feature `gamepad`: no game pad moves a robot.

use eframe::egui::Ui;

use super::Sticks;

#[derive(Default)]
pub(super) struct Gamepads;

impl Gamepads {
    pub(super) fn sticks(&mut self, _: &mut Ui) -> Sticks {
        Sticks::default()
    }
}
