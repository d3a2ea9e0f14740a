//! The panels of a recording, with the interface of a running application's panels. Their widgets cannot be
//! touched.

use std::collections::BTreeMap;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use jde_core::Nanos;
use jde_host::Drawn;
use jde_link::{Looking, News};
use jde_panel::List;

/// Shown while the recording has no drawing of a panel.
const NOTHING: &str = "nothing of it was recorded before this time";

/// All panels of a recording.
pub(super) struct Gallery {
    shown: Mutex<BTreeMap<String, Option<Arc<Drawn>>>>,
    lookers: Mutex<BTreeMap<u64, (String, News)>>,
    /// Counts drawings and viewers.
    count: AtomicU64,
}

struct Visitor {
    gallery: Arc<Gallery>,
    schema: String,
    number: u64,
}

impl Gallery {
    /// Creates the panels of some schemas, without any drawing.
    pub(super) fn new<'n>(schemas: impl Iterator<Item = &'n String>) -> Arc<Self> {
        Arc::new(Self {
            shown: Mutex::new(schemas.map(|schema| (schema.clone(), None)).collect()),
            lookers: Mutex::default(),
            count: AtomicU64::new(0),
        })
    }

    /// Shows what the panel of a schema showed at a time.
    pub(super) fn show(&self, schema: &str, time: Nanos, list: Result<List, String>) {
        let drawn = Drawn {
            sequence: self.next(),
            time,
            took: Duration::ZERO,
            failed: 0,
            list,
        };
        if let Some(shown) = lock(&self.shown).get_mut(schema) {
            *shown = Some(Arc::new(drawn));
        }
        for (looked_at, news) in lock(&self.lookers).values() {
            if looked_at == schema {
                news();
            }
        }
    }

    /// Replaces every panel by [`NOTHING`]: the next drawings belong to another time.
    pub(super) fn clear(&self, time: Nanos) {
        let schemas: Vec<_> = lock(&self.shown).keys().cloned().collect();
        for schema in schemas {
            self.show(&schema, time, Err(NOTHING.to_owned()));
        }
    }

    /// Adds a viewer. Returns `None` if the schema has no panel.
    pub(super) fn look(self: &Arc<Self>, schema: &str, news: News) -> Option<Box<dyn Looking>> {
        if !lock(&self.shown).contains_key(schema) {
            return None;
        }
        let number = self.next();
        lock(&self.lookers).insert(number, (schema.to_owned(), news));
        Some(Box::new(Visitor {
            gallery: Arc::clone(self),
            schema: schema.to_owned(),
            number,
        }))
    }

    /// The schemas that have panels.
    pub(super) fn schemas(&self) -> Vec<String> {
        lock(&self.shown).keys().cloned().collect()
    }

    fn next(&self) -> u64 {
        self.count.fetch_add(1, Ordering::Relaxed) + 1
    }
}

impl Looking for Visitor {
    fn newest(&self) -> Option<Arc<Drawn>> {
        lock(&self.gallery.shown).get(&self.schema)?.clone()
    }
}

impl Drop for Visitor {
    fn drop(&mut self) {
        lock(&self.gallery.lookers).remove(&self.number);
    }
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
