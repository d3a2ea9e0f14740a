//! What a panel's window keeps from list to list: what a person just moved, where they look, how they sorted, and pictures on
//! the graphics card. A widget is the same one while its `id` is.

use std::collections::HashMap;
use std::sync::Arc;
use std::time::{Duration, Instant};

use eframe::egui::{TextureHandle, Ui};
use jde_panel::{Area, List};

use super::table::Sorted;
use crate::canvas::{Gestures, View};

/// What a person moved stays as moved for so long, unless the schema says something new of it: lists that were on their way
/// when it was touched would throw it back.
const PATIENCE: Duration = Duration::from_secs(1);
/// What a plane without an area shows is fitted anew when it shrank to this share.
const SHRUNK: f64 = 0.4;

/// What is kept.
#[derive(Default)]
pub(super) struct PanelState {
    list: Option<Arc<List>>,
    moved: HashMap<String, PendingValue>,
    views: HashMap<String, View>,
    homes: HashMap<String, Area>,
    /// What is under way on pictures.
    pub(super) hands: HashMap<String, Gestures>,
    pub(super) sorted: HashMap<String, Sorted>,
    pub(super) textures: HashMap<String, Texture>,
    /// Counts lists.
    pub(super) serial: u64,
    /// Height of all that is not stretched, as of the frame before.
    pub(super) small: f32,
}

/// A picture on the graphics card.
pub(super) struct Texture {
    pub(super) handle: TextureHandle,
    /// Of which list.
    pub(super) serial: u64,
}

/// What a person moved, as a number.
struct PendingValue {
    to: f64,
    /// What the list said before.
    from: f64,
    until: Instant,
}

impl PanelState {
    /// What one kept before.
    pub(super) fn read(json: &serde_json::Value) -> Self {
        Self {
            views: serde_json::from_value(json["views"].clone()).unwrap_or_default(),
            ..Self::default()
        }
    }

    /// What is kept from one start to the next.
    pub(super) fn write(&self) -> serde_json::Value {
        let views: HashMap<_, _> = self.views.iter().filter(|(_, view)| !view.is_fitted()).collect();
        if views.is_empty() {
            return serde_json::Value::Null;
        }
        serde_json::json!({ "views": views })
    }

    /// Takes note of the list that is shown.
    pub(super) fn take(&mut self, list: &Arc<List>) {
        if self.list.as_ref().is_some_and(|old| Arc::ptr_eq(old, list)) {
            return;
        }
        self.list = Some(Arc::clone(list));
        self.serial += 1;
        // What left the panel leaves the graphics card.
        let serial = self.serial;
        self.textures.retain(|_, texture| texture.serial + 2 > serial);
    }

    /// What a widget is to show, if the list says `said`.
    pub(super) fn shown(&mut self, ui: &Ui, id: &str, said: f64) -> f64 {
        let Some(moved) = self.moved.get(id) else {
            return said;
        };
        let left = moved.until.saturating_duration_since(Instant::now());
        if moved.from == said && !left.is_zero() {
            ui.ctx().request_repaint_after(left);
            return moved.to;
        }
        self.moved.remove(id);
        said
    }

    /// A person moved a widget, of which the list says `from`.
    pub(super) fn moved(&mut self, id: &str, from: f64, to: f64) {
        let until = Instant::now() + PATIENCE;
        self.moved.insert(id.to_owned(), PendingValue { to, from, until });
    }

    /// What a person sees of a plane; given back by [`Self::look_at`].
    pub(super) fn view(&mut self, id: &str) -> View {
        self.views.remove(id).unwrap_or_default()
    }

    /// Keeps what a person sees of a plane.
    pub(super) fn look_at(&mut self, id: &str, view: View) {
        self.views.insert(id.to_owned(), view);
    }

    /// What a plane shows at first that says nothing of it: all that is drawn, but not jumping with every move of it.
    pub(super) fn home(&mut self, id: &str, drawn: Area) -> Area {
        let size = |area: &Area, axis: usize| area.greatest[axis] - area.least[axis];
        let home = self.homes.entry(id.to_owned()).or_insert(drawn);
        let outside = (0..2)
            .any(|axis| drawn.least[axis] < home.least[axis] || drawn.greatest[axis] > home.greatest[axis]);
        let small = (0..2).all(|axis| size(&drawn, axis) < SHRUNK * size(home, axis));
        if outside || small {
            let room = |axis: usize| 0.08 * size(&drawn, axis);
            *home = Area {
                least: [drawn.least[0] - room(0), drawn.least[1] - room(1)],
                greatest: [drawn.greatest[0] + room(0), drawn.greatest[1] + room(1)],
            };
        }
        *home
    }
}
