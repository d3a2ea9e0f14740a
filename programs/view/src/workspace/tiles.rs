//! How a tile is drawn: its window, and a tab that can be closed.

use std::collections::HashMap;

use eframe::egui;
use egui_tiles::{Behavior, SimplificationOptions, Tile, TileId, Tiles, UiResponse};

use crate::session::WindowSession;
use crate::style::Style;
use crate::window::{Window, WindowKind};

/// Draws the tiles of one frame.
pub(super) struct Tiling<'a> {
    pub(super) session: &'a WindowSession,
    pub(super) windows: &'a mut HashMap<WindowKind, Box<dyn Window>>,
    pub(super) saved_windows: &'a HashMap<String, serde_json::Value>,
    pub(super) style: &'a Style,
}

impl Behavior<WindowKind> for Tiling<'_> {
    fn tab_title_for_pane(&mut self, pane: &WindowKind) -> egui::WidgetText {
        pane.title().into()
    }

    fn pane_ui(&mut self, ui: &mut egui::Ui, _tile: TileId, pane: &mut WindowKind) -> UiResponse {
        let saved_windows = self.saved_windows;
        let window = self.windows.entry(pane.clone()).or_insert_with(|| {
            let saved = saved_windows
                .get(&pane.title())
                .unwrap_or(&serde_json::Value::Null);
            pane.open(saved)
        });
        let id = ui.scope_id().with(&*pane);
        // The background is already drawn: a software renderer pays for every pixel that is drawn twice.
        egui::Frame::new().inner_margin(4).show(ui, |ui| {
            ui.push_id(id, |ui| window.show(ui, self.session, self.style));
            ui.allocate_space(ui.available_size());
        });
        UiResponse::None
    }

    fn is_tab_closable(&self, _tiles: &Tiles<WindowKind>, _tile: TileId) -> bool {
        true
    }

    fn on_tab_close(&mut self, tiles: &mut Tiles<WindowKind>, tile: TileId) -> bool {
        if let Some(Tile::Pane(kind)) = tiles.get(tile) {
            self.windows.remove(kind);
        }
        true
    }

    fn simplification_options(&self) -> SimplificationOptions {
        // Every window keeps its tab, by which the user drags it.
        SimplificationOptions {
            all_panes_must_have_tabs: true,
            ..SimplificationOptions::default()
        }
    }
}
