//! The panels that are looked at: those that a window asked for lately. A schema draws for nobody else.
//!
//! Looking begins with a question to the application, which a thread of its own asks.

use std::collections::HashMap;
use std::sync::mpsc::{Sender, channel};
use std::sync::{Arc, Mutex};
use std::thread;
use std::time::{Duration, Instant};

use eframe::egui;
use jde_link::{Rate, Remote, Watching};
use jde_panel::List;

use super::demand::Demand;
use super::lock;

/// What failed is tried again after so long.
const AGAIN: Duration = Duration::from_secs(3);

/// A list as it came, or why there is none.
pub(crate) type PanelContent = Result<Arc<List>, String>;

pub(super) struct Panels {
    questions: Sender<Request>,
    looked: HashMap<String, WatchedPanel>,
}

type Request = (String, Rate, Arc<Mutex<Slot>>);

struct WatchedPanel {
    rate: Rate,
    demand: Demand,
    slot: Arc<Mutex<Slot>>,
}

/// What the link's threads fill.
#[derive(Default)]
struct Slot {
    newest: Option<PanelContent>,
    refused: Option<Instant>,
    watching: Option<Watching>,
}

impl Panels {
    pub(super) fn new(remote: Remote, repaint: egui::Context) -> Self {
        let (questions, asked) = channel::<Request>();
        let eyes = move || {
            for (schema, rate, slot) in asked {
                // Nobody looks any more.
                if Arc::strong_count(&slot) == 1 {
                    continue;
                }
                let (progress, again) = (Arc::downgrade(&slot), repaint.clone());
                let watching = remote.watch_panel(&schema, rate, move |panel| {
                    let Some(slot) = progress.upgrade() else { return };
                    lock(&slot).newest = Some(panel.list.map(Arc::new));
                    again.request_repaint();
                });
                let mut slot = lock(&slot);
                match watching {
                    Ok(watching) => (slot.watching, slot.refused) = (Some(watching), None),
                    Err(error) => {
                        slot.newest = Some(Err(error.to_string()));
                        slot.refused = Some(Instant::now());
                    }
                }
                repaint.request_repaint();
            }
        };
        // It ends when its sender is gone; there is nothing to wait for.
        if let Err(error) = thread::Builder::new().name("view-panels".to_owned()).spawn(eyes) {
            tracing::error!("no thread to look at panels: {error}");
        }
        Self {
            questions,
            looked: HashMap::new(),
        }
    }

    pub(super) fn newest(&mut self, schema: &str, rate: Rate) -> Option<PanelContent> {
        let looked = match self.looked.get_mut(schema) {
            Some(looked) => looked,
            None => {
                let mut looked = WatchedPanel::new(rate);
                looked.look(&self.questions, schema, rate);
                self.looked.entry(schema.to_owned()).or_insert(looked)
            }
        };
        if looked.rate < rate {
            looked.look(&self.questions, schema, rate);
        }
        looked.demand.ask(rate, Instant::now());
        lock(&looked.slot).newest.clone()
    }

    /// Lets go of what nobody looks at any more, looks less often at what is wanted less often, and tries again what was refused.
    pub(super) fn remove_unused(&mut self) {
        let now = Instant::now();
        let questions = &self.questions;
        self.looked.retain(|schema, looked| {
            let Some(rate) = looked.demand.greatest(now) else {
                return false;
            };
            if rate < looked.rate {
                looked.look(questions, schema, rate);
                return true;
            }
            let mut slot = lock(&looked.slot);
            if slot
                .refused
                .is_some_and(|since| now.saturating_duration_since(since) > AGAIN)
            {
                slot.refused = None;
                let _ = questions.send((schema.clone(), rate, Arc::clone(&looked.slot)));
            }
            true
        });
    }
}

impl WatchedPanel {
    fn new(rate: Rate) -> Self {
        Self {
            rate,
            demand: Demand::default(),
            slot: Arc::default(),
        }
    }

    /// Has it looked at so often. What came before is shown until more comes.
    fn look(&mut self, questions: &Sender<Request>, schema: &str, rate: Rate) {
        let newest = lock(&self.slot).newest.take();
        // The old one hears nothing any more: nobody holds it.
        self.slot = Arc::new(Mutex::new(Slot {
            newest,
            ..Slot::default()
        }));
        self.rate = rate;
        // Without a thread to ask nothing comes, and the log says why.
        let _ = questions.send((schema.to_owned(), rate, Arc::clone(&self.slot)));
    }
}
