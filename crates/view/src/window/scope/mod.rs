//! The hierarchy over time: who was in which state, who won, and why.

use eframe::egui;

use super::Window;
use crate::look::Look;
use crate::session::Session;

/// The window.
pub(crate) struct Scope {}

impl Scope {
    /// With what one kept before.
    pub(crate) fn open(_kept: &serde_json::Value) -> Self {
        Self {}
    }
}

impl Window for Scope {
    fn show(&mut self, ui: &mut egui::Ui, session: &Session, _look: &Look) {
        ui.label(&session.about().application);
    }
}
