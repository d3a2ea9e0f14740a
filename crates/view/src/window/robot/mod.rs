//! Sensors and motors: what the robot senses around its outline, and teleoperation.

use eframe::egui;

use super::Window;
use crate::look::Look;
use crate::session::Session;

/// The window.
pub(crate) struct Robot {}

impl Robot {
    /// With what one kept before.
    pub(crate) fn open(_kept: &serde_json::Value) -> Self {
        Self {}
    }
}

impl Window for Robot {
    fn show(&mut self, ui: &mut egui::Ui, session: &Session, _look: &Look) {
        ui.label(&session.about().application);
    }
}
