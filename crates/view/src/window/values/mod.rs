//! Variables and modulations, by schema.

use eframe::egui;

use super::Window;
use crate::look::Look;
use crate::session::Session;

/// The window.
pub(crate) struct Values {}

impl Values {
    /// With what one kept before.
    pub(crate) fn open(_kept: &serde_json::Value) -> Self {
        Self {}
    }
}

impl Window for Values {
    fn show(&mut self, ui: &mut egui::Ui, session: &Session, _look: &Look) {
        ui.label(&session.about().application);
    }
}
