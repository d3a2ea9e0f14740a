//! The windows on one application: docked tiles under a bar with its name and status. The layout is saved for
//! each application and restored at the next start.

mod bar;
mod marks;
mod menu;
mod seek_bar;
mod tiles;

pub(crate) use menu::appearance_menu;

use std::collections::HashMap;
use std::path::Path;

use eframe::egui;
use egui_tiles::{Tile, TileId, Tiles, Tree};
use jde_link::Reach;
use jde_link::message::About;
use serde::{Deserialize, Serialize};

use crate::player::Player;
use crate::recorder::Recorder;
use crate::session::WindowSession;
use crate::settings::SettingsStore;
use crate::start::Discovery;
use crate::style::Style;
use crate::window::{Window, WindowKind};

/// The windows on an application.
pub(crate) struct Workspace {
    session: WindowSession,
    tree: Tree<WindowKind>,
    windows: HashMap<WindowKind, Box<dyn Window>>,
    saved_windows: HashMap<String, serde_json::Value>,
    store: SettingsStore,
    /// The layout as last written. An unchanged layout is not written again.
    saved: Option<String>,
    saved_at: f64,
    /// The process that plays the recording for these windows. It ends with them.
    player: Option<Player>,
    recorder: Recorder,
    slider: seek_bar::SeekBar,
    reach: Reach,
    /// Searches for a new run of an application that is gone.
    discovery: Option<Discovery>,
    /// Whether the button that lets everything go on asks.
    asks: bool,
}

/// What the user wants instead of these windows.
pub(crate) enum Navigation {
    /// The start page.
    Away,
    /// The windows on this application.
    For(Box<About>),
}

/// The layout as saved.
#[derive(Serialize, Deserialize)]
struct SavedLayout {
    tree: Tree<WindowKind>,
    windows: HashMap<String, serde_json::Value>,
}

impl Workspace {
    /// Opens the windows on an application, in its saved layout.
    pub(crate) fn open(
        session: WindowSession,
        store: SettingsStore,
        player: Option<Player>,
        recorder: Recorder,
        reach: Reach,
    ) -> Self {
        let saved_layout: Option<SavedLayout> = store.take(&layout_name(&session));
        let (tree, saved_windows) = match saved_layout {
            // The user may have closed all windows; then the default layout is used.
            Some(saved_layout) if saved_layout.tree.root().is_some() => {
                (saved_layout.tree, saved_layout.windows)
            }
            Some(_) | None => (default_layout(&session), HashMap::new()),
        };
        Self {
            session,
            tree,
            windows: HashMap::new(),
            saved_windows,
            store,
            saved: None,
            saved_at: 0.0,
            player,
            recorder,
            slider: seek_bar::SeekBar::default(),
            reach,
            discovery: None,
            asks: false,
        }
    }

    /// The application that the windows show.
    pub(crate) fn session(&mut self) -> &mut WindowSession {
        &mut self.session
    }

    /// Takes in what arrived since the last frame. Call once at the beginning of each frame, also while another page is shown.
    pub(crate) fn begin_frame(&mut self) {
        self.session.begin_frame();
        for window in self.windows.values_mut() {
            window.follow(&self.session);
        }
    }

    /// The recording that these windows play.
    pub(crate) fn recording(&self) -> Option<&Path> {
        self.player.as_ref().map(Player::file)
    }

    /// Draws all windows below the bar; `stopping` while a stop of everything is under way.
    pub(crate) fn show(&mut self, ui: &mut egui::Ui, style: &Style, stopping: bool) {
        self.stopped(ui, stopping);
        if self.session.is_recording() {
            egui::Panel::bottom("replay").show(ui, |ui| self.slider.show(ui, &self.session));
        }
        egui::CentralPanel::no_frame().show(ui, |ui| {
            let mut shown = tiles::Tiling {
                session: &self.session,
                windows: &mut self.windows,
                saved_windows: &self.saved_windows,
                style,
            };
            self.tree.ui(&mut shown, ui);
        });
        for kind in self.session.openings() {
            self.show_window(kind);
        }
        let now = ui.input(|input| input.time);
        if now - self.saved_at > 2.0 {
            self.saved_at = now;
            self.save();
        }
    }

    /// Whether the workspace has this window.
    fn has(&self, kind: &WindowKind) -> bool {
        self.place(kind).is_some()
    }

    fn place(&self, kind: &WindowKind) -> Option<TileId> {
        self.tree
            .tiles
            .iter()
            .find_map(|(id, tile)| matches!(tile, Tile::Pane(pane) if pane == kind).then_some(*id))
    }

    /// Adds a window to the workspace, or brings its tab to the front.
    fn show_window(&mut self, kind: WindowKind) {
        if self.place(&kind).is_none() {
            let pane = self.tree.tiles.insert_pane(kind.clone());
            match self.tree.root() {
                None => {
                    self.tree = Tree::new(
                        egui::Id::unique("desk"),
                        pane,
                        std::mem::take(&mut self.tree.tiles),
                    )
                }
                Some(root) => self.dock(root, pane),
            }
        }
        let shown = kind;
        self.tree
            .make_active(|_, tile| matches!(tile, Tile::Pane(pane) if *pane == shown));
    }

    /// Docks a new window. It joins the existing panels if there are any, or else the root.
    fn dock(&mut self, root: TileId, pane: TileId) {
        let beside = self
            .tree
            .tiles
            .iter()
            .find_map(|(id, tile)| {
                (*id != pane && matches!(tile, Tile::Pane(WindowKind::Panel(_)))).then_some(*id)
            })
            .and_then(|panel| self.tree.tiles.parent_of(panel));
        let place = beside.unwrap_or(root);
        match self.tree.tiles.get_mut(place) {
            Some(Tile::Container(container)) => container.add_child(pane),
            Some(Tile::Pane(_)) | None => {
                let root = self.tree.tiles.insert_horizontal_tile(vec![root, pane]);
                self.tree.root = Some(root);
            }
        }
    }

    fn hide_window(&mut self, kind: &WindowKind) {
        if let Some(place) = self.place(kind) {
            self.tree.remove_recursively(place);
            self.windows.remove(kind);
        }
    }

    /// Restores the default layout.
    fn restore_default_layout(&mut self) {
        self.tree = default_layout(&self.session);
    }

    fn save(&mut self) {
        for (kind, window) in &self.windows {
            self.saved_windows.insert(kind.title(), window.keep());
        }
        let saved_layout = SavedLayout {
            tree: self.tree.clone(),
            windows: self.saved_windows.clone(),
        };
        let Ok(text) = serde_json::to_string(&saved_layout) else {
            return;
        };
        if self.saved.as_ref() != Some(&text) {
            self.store.keep(&layout_name(&self.session), &saved_layout);
            self.saved = Some(text);
        }
    }
}

impl Drop for Workspace {
    fn drop(&mut self) {
        self.save();
    }
}

/// The name under which the layout is saved. A recording shares the layout of its application.
fn layout_name(session: &WindowSession) -> String {
    format!("desk-{}", session.about().application)
}

/// The default layout.
fn default_layout(session: &WindowSession) -> Tree<WindowKind> {
    let mut tiles = Tiles::default();
    let mut tab = |kinds: Vec<WindowKind>| {
        let panes = kinds.into_iter().map(|kind| tiles.insert_pane(kind)).collect();
        tiles.insert_tab_tile(panes)
    };
    let scope = tab(vec![
        WindowKind::Oscilloscope,
        WindowKind::Values,
        WindowKind::Events,
    ]);
    let without_father = session.panels().filter(|schema| {
        let father = session.schema(schema).and_then(|schema| schema.father.as_ref());
        father.is_none()
    });
    // A root before the perceptive schemas and drivers, which compete in no group.
    let father = without_father.min_by_key(|schema| {
        let group = session.schema(schema).and_then(|schema| schema.group.as_ref());
        group.is_none()
    });
    let mut senses = vec![WindowKind::Robot];
    senses.extend(father.map(|schema| WindowKind::Panel(schema.to_owned())));
    let robot = tab(senses);
    let space = tab(vec![WindowKind::Space]);
    let right = tiles.insert_vertical_tile(vec![robot, space]);
    let root = tiles.insert_horizontal_tile(vec![scope, right]);
    if let Some(Tile::Container(egui_tiles::Container::Linear(row))) = tiles.get_mut(root) {
        row.shares.set_share(scope, 1.3);
    }
    Tree::new(egui::Id::unique("desk"), root, tiles)
}
