//! What a panel's window keeps from list to list: pending values, views of planes, sort orders, and textures.
//! Two widgets with the same `id` are the same widget.

use std::collections::HashMap;
use std::sync::Arc;
use std::time::{Duration, Instant};

use eframe::egui::{TextureHandle, Ui};
use jde_panel::{Area, List};

use super::table::Sorted;
use crate::canvas::{Gestures, View};

/// How long a widget shows the value that the user set, unless the schema reports a new one. Lists that were
/// in transit at that time would otherwise reset it.
const USER_VALUE_TIME: Duration = Duration::from_secs(1);
/// A plane without an area is fitted anew when its content shrinks below this fraction of the fitted area.
const REFIT_SHARE: f64 = 0.4;

/// The state of a panel's window.
#[derive(Default)]
pub(super) struct PanelState {
    list: Option<Arc<List>>,
    moved: HashMap<String, PendingValue>,
    views: HashMap<String, View>,
    homes: HashMap<String, Area>,
    /// Gestures in progress on images.
    pub(super) gestures: HashMap<String, Gestures>,
    pub(super) sorted: HashMap<String, Sorted>,
    pub(super) textures: HashMap<String, Texture>,
    /// Number of lists so far.
    pub(super) serial: u64,
    /// Height of the widgets that do not stretch, as of the last frame, in points.
    pub(super) small: f32,
}

/// An image on the graphics card.
pub(super) struct Texture {
    pub(super) handle: TextureHandle,
    /// The serial number of its list.
    pub(super) serial: u64,
}

/// A value that the user set, as a number.
struct PendingValue {
    to: f64,
    /// The value of the list at that time.
    from: f64,
    until: Instant,
}

impl PanelState {
    /// Reads the saved state.
    pub(super) fn read(json: &serde_json::Value) -> Self {
        Self {
            views: serde_json::from_value(json["views"].clone()).unwrap_or_default(),
            ..Self::default()
        }
    }

    /// The state to save for the next start: the views that the user changed.
    pub(super) fn write(&self) -> serde_json::Value {
        let views: HashMap<_, _> = self.views.iter().filter(|(_, view)| !view.is_fitted()).collect();
        if views.is_empty() {
            return serde_json::Value::Null;
        }
        serde_json::json!({ "views": views })
    }

    /// Registers the list that is shown. Does nothing if it is the same.
    pub(super) fn take(&mut self, list: &Arc<List>) {
        if self.list.as_ref().is_some_and(|old| Arc::ptr_eq(old, list)) {
            return;
        }
        self.list = Some(Arc::clone(list));
        self.serial += 1;
        // Frees the textures of images that are no longer in the panel.
        let serial = self.serial;
        self.textures.retain(|_, texture| texture.serial + 2 > serial);
    }

    /// The value that a widget shows when the list has `reported`.
    pub(super) fn shown(&mut self, ui: &Ui, id: &str, reported: f64) -> f64 {
        let Some(moved) = self.moved.get(id) else {
            return reported;
        };
        let remaining = moved.until.saturating_duration_since(Instant::now());
        if moved.from == reported && !remaining.is_zero() {
            ui.ctx().request_repaint_after(remaining);
            return moved.to;
        }
        self.moved.remove(id);
        reported
    }

    /// Records that the user moved a widget, for which the list has `from`.
    pub(super) fn moved(&mut self, id: &str, from: f64, to: f64) {
        let until = Instant::now() + USER_VALUE_TIME;
        self.moved.insert(id.to_owned(), PendingValue { to, from, until });
    }

    /// Removes and returns the view of a plane. [`Self::look_at`] puts it back.
    pub(super) fn view(&mut self, id: &str) -> View {
        self.views.remove(id).unwrap_or_default()
    }

    /// Keeps the view of a plane.
    pub(super) fn look_at(&mut self, id: &str, view: View) {
        self.views.insert(id.to_owned(), view);
    }

    /// The home area of a plane that declares none. It contains all shapes, and does not change with each of
    /// their movements.
    pub(super) fn home(&mut self, id: &str, drawn: Area) -> Area {
        let size = |area: &Area, axis: usize| area.greatest[axis] - area.least[axis];
        let home = self.homes.entry(id.to_owned()).or_insert(drawn);
        let outside = (0..2)
            .any(|axis| drawn.least[axis] < home.least[axis] || drawn.greatest[axis] > home.greatest[axis]);
        let small = (0..2).all(|axis| size(&drawn, axis) < REFIT_SHARE * size(home, axis));
        if outside || small {
            let margin = |axis: usize| 0.08 * size(&drawn, axis);
            *home = Area {
                least: [drawn.least[0] - margin(0), drawn.least[1] - margin(1)],
                greatest: [drawn.greatest[0] + margin(0), drawn.greatest[1] + margin(1)],
            };
        }
        *home
    }
}
