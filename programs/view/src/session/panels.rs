//! The panels that a window requested lately. A schema draws its panel only for these.

use std::sync::Arc;

use eframe::egui;
use jde_link::{Rate, Remote};
use jde_panel::List;

use super::watch_list::WatchList;

/// The newest list of a panel, or why there is none.
pub(crate) type PanelContent = Result<Arc<List>, String>;

pub(super) struct Panels(WatchList<Option<PanelContent>>);

impl Panels {
    pub(super) fn new(remote: Remote, repaint: egui::Context) -> Self {
        Self(WatchList::new(
            "view-panels",
            repaint,
            move |schema, rate, sink| {
                remote.watch_panel(schema, rate, move |panel| {
                    sink.update(|newest| *newest = Some(panel.list.map(Arc::new)));
                })
            },
        ))
    }

    pub(super) fn newest(&mut self, schema: &str, rate: Rate) -> Option<PanelContent> {
        let slot = self.0.request(schema, rate);
        slot.failure().map(Err).or_else(|| slot.received.clone())
    }

    pub(super) fn remove_unused(&mut self) {
        self.0.remove_unused();
    }
}
