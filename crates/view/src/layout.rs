//! The windows on one application as docked tiles; saved for each application, and read back at the next start.

use std::collections::HashMap;

use eframe::egui;
use egui_tiles::{Behavior, TileId, Tiles, Tree, UiResponse};
use serde::{Deserialize, Serialize};

use crate::look::{Look, Units};
use crate::session::Session;
use crate::window::{Kind, Window};

/// What a person chose for all applications.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
#[serde(default, rename_all = "kebab-case")]
pub(crate) struct Settings {
    /// Units of numbers.
    pub(crate) units: Units,
    /// Dark, light, or as the desktop.
    pub(crate) theme: egui::ThemePreference,
}

impl Settings {
    pub(crate) fn load() -> Self {
        Self::default()
    }

    pub(crate) fn apply(&self, ctx: &egui::Context) {
        ctx.set_theme(self.theme);
    }
}

/// The windows on an application.
pub(crate) struct Desk {
    session: Session,
    tree: Tree<Kind>,
    windows: HashMap<Kind, Box<dyn Window>>,
}

impl Desk {
    pub(crate) fn open(session: Session) -> Self {
        let mut tiles = Tiles::default();
        let left = vec![
            tiles.insert_pane(Kind::Oscilloscope),
            tiles.insert_pane(Kind::Values),
        ];
        let left = tiles.insert_tab_tile(left);
        let right = vec![tiles.insert_pane(Kind::Robot), tiles.insert_pane(Kind::Space)];
        let right = tiles.insert_vertical_tile(right);
        let root = tiles.insert_horizontal_tile(vec![left, right]);
        Self {
            session,
            tree: Tree::new(egui::Id::new("desk"), root, tiles),
            windows: HashMap::new(),
        }
    }

    /// Draws all of it; answers whether the person wants to leave.
    pub(crate) fn show(&mut self, ui: &mut egui::Ui, look: &Look, _settings: &mut Settings) -> bool {
        self.session.begin_frame();
        let mut tiles = Shown {
            session: &self.session,
            windows: &mut self.windows,
            look,
        };
        self.tree.ui(&mut tiles, ui);
        false
    }
}

/// Draws tiles.
struct Shown<'a> {
    session: &'a Session,
    windows: &'a mut HashMap<Kind, Box<dyn Window>>,
    look: &'a Look,
}

impl Behavior<Kind> for Shown<'_> {
    fn tab_title_for_pane(&mut self, pane: &Kind) -> egui::WidgetText {
        pane.title().into()
    }

    fn pane_ui(&mut self, ui: &mut egui::Ui, _tile: TileId, pane: &mut Kind) -> UiResponse {
        let window = self
            .windows
            .entry(pane.clone())
            .or_insert_with(|| pane.open(&serde_json::Value::Null));
        egui::Frame::central_panel(ui.style()).show(ui, |ui| window.show(ui, self.session, self.look));
        UiResponse::None
    }
}
