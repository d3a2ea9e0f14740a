//! The panels of a recording, with the interface of a running application's panels. Their widgets cannot be
//! touched.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

use jde_core::Nanos;
use jde_link::{OnDrawn, PanelViewer};
use jde_panel::List;
use jde_panel::PanelFrame;
use parking_lot::Mutex;

/// Shown while the recording has no drawing of a panel.
const NO_DRAWING: &str = "nothing of it was recorded before this time";

/// All panels of a recording.
pub(super) struct PanelStore {
    drawings: Mutex<BTreeMap<String, Option<Arc<PanelFrame>>>>,
    viewers: Mutex<BTreeMap<u64, (String, OnDrawn)>>,
    /// Counts drawings and viewers.
    count: AtomicU64,
}

struct RecordedPanelViewer {
    store: Arc<PanelStore>,
    schema: String,
    number: u64,
}

impl PanelStore {
    /// Creates the panels of some schemas, without any drawing.
    pub(super) fn new<'n>(schemas: impl Iterator<Item = &'n String>) -> Arc<Self> {
        Arc::new(Self {
            drawings: Mutex::new(schemas.map(|schema| (schema.clone(), None)).collect()),
            viewers: Mutex::default(),
            count: AtomicU64::new(0),
        })
    }

    /// Shows what the panel of a schema showed at a time.
    pub(super) fn set_drawing(&self, schema: &str, time: Nanos, list: Result<List, String>) {
        let frame = PanelFrame {
            sequence: self.next_number(),
            time,
            took: Duration::ZERO,
            failed: 0,
            list,
        };
        if let Some(shown) = self.drawings.lock().get_mut(schema) {
            *shown = Some(Arc::new(frame));
        }
        for (viewed, on_drawn) in self.viewers.lock().values() {
            if viewed == schema {
                on_drawn();
            }
        }
    }

    /// Replaces every panel by [`NO_DRAWING`]: the next drawings belong to another time.
    pub(super) fn clear(&self, time: Nanos) {
        let schemas: Vec<_> = self.drawings.lock().keys().cloned().collect();
        for schema in schemas {
            self.set_drawing(&schema, time, Err(NO_DRAWING.to_owned()));
        }
    }

    /// Adds a viewer. Returns `None` if the schema has no panel.
    pub(super) fn add_viewer(
        self: &Arc<Self>,
        schema: &str,
        on_drawn: OnDrawn,
    ) -> Option<Box<dyn PanelViewer>> {
        if !self.drawings.lock().contains_key(schema) {
            return None;
        }
        let number = self.next_number();
        self.viewers.lock().insert(number, (schema.to_owned(), on_drawn));
        Some(Box::new(RecordedPanelViewer {
            store: Arc::clone(self),
            schema: schema.to_owned(),
            number,
        }))
    }

    /// The schemas that have panels.
    pub(super) fn schemas(&self) -> Vec<String> {
        self.drawings.lock().keys().cloned().collect()
    }

    fn next_number(&self) -> u64 {
        self.count.fetch_add(1, Ordering::Relaxed) + 1
    }
}

impl PanelViewer for RecordedPanelViewer {
    fn newest(&self) -> Option<Arc<PanelFrame>> {
        self.store.drawings.lock().get(&self.schema)?.clone()
    }
}

impl Drop for RecordedPanelViewer {
    fn drop(&mut self) {
        self.store.viewers.lock().remove(&self.number);
    }
}
