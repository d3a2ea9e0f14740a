//! The panel that a schema draws of itself.

use eframe::egui;

use super::Window;
use crate::look::Look;
use crate::session::Session;

/// The window.
pub(crate) struct Panel {
    schema: String,
}

impl Panel {
    /// Of a schema, with what one kept before.
    pub(crate) fn open(schema: &str, _kept: &serde_json::Value) -> Self {
        Self {
            schema: schema.to_owned(),
        }
    }
}

impl Window for Panel {
    fn show(&mut self, ui: &mut egui::Ui, _session: &Session, _look: &Look) {
        ui.label(&self.schema);
    }
}
