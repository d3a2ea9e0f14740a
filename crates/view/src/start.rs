//! The start page: what runs here or where the user pointed, and recordings at hand. A click opens either.

use std::path::PathBuf;

use eframe::egui;
use jde_link::message::About;

use crate::Opening;
use crate::layout::Settings;

/// What was chosen.
pub(crate) enum Chosen {
    /// An application that runs.
    Application(Box<About>),
    /// A recording.
    Recording(PathBuf),
}

/// The page.
pub(crate) struct Start {
    /// Why the last choice came to nothing.
    pub(crate) trouble: Option<String>,
}

impl Start {
    pub(crate) fn new(_opening: &Opening) -> Self {
        Self { trouble: None }
    }

    /// Draws it; answers with what was chosen.
    pub(crate) fn show(&mut self, ui: &mut egui::Ui, _settings: &mut Settings) -> Option<Chosen> {
        if let Some(trouble) = &self.trouble {
            ui.label(trouble);
        }
        None
    }
}
