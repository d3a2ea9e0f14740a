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

use super::lock;

/// What nobody asks for any more is let go after so long.
const PATIENCE: Duration = Duration::from_secs(2);
/// What failed is tried again after so long.
const AGAIN: Duration = Duration::from_secs(3);

/// A list as it came, or why there is none.
pub(crate) type Picture = Result<Arc<List>, String>;

pub(super) struct Panels {
    questions: Sender<Question>,
    looked: HashMap<String, Looked>,
}

type Question = (String, Rate, Arc<Mutex<Slot>>);

struct Looked {
    rate: Rate,
    asked: Instant,
    slot: Arc<Mutex<Slot>>,
}

/// What the link's threads fill.
#[derive(Default)]
struct Slot {
    newest: Option<Picture>,
    refused: Option<Instant>,
    watching: Option<Watching>,
}

impl Panels {
    pub(super) fn new(remote: Remote, repaint: egui::Context) -> Self {
        let (questions, asked) = channel::<Question>();
        let eyes = move || {
            for (schema, rate, slot) in asked {
                // Nobody looks any more.
                if Arc::strong_count(&slot) == 1 {
                    continue;
                }
                let (heard, again) = (Arc::downgrade(&slot), repaint.clone());
                let watching = remote.watch_panel(&schema, rate, move |panel| {
                    let Some(slot) = heard.upgrade() else { return };
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

    pub(super) fn newest(&mut self, schema: &str, rate: Rate) -> Option<Picture> {
        let known = self.looked.get(schema).is_some_and(|looked| looked.rate >= rate);
        if !known {
            let before = self.looked.remove(schema);
            let slot = Arc::new(Mutex::new(Slot {
                newest: before.and_then(|before| lock(&before.slot).newest.take()),
                ..Slot::default()
            }));
            // Without a thread to ask nothing comes, and the log says why.
            let _ = self.questions.send((schema.to_owned(), rate, Arc::clone(&slot)));
            let asked = Instant::now();
            self.looked
                .insert(schema.to_owned(), Looked { rate, asked, slot });
        }
        let looked = self.looked.get_mut(schema)?;
        looked.asked = Instant::now();
        lock(&looked.slot).newest.clone()
    }

    /// Lets go of what nobody looks at any more, and tries again what was refused.
    pub(super) fn tidy(&mut self) {
        let questions = &self.questions;
        self.looked.retain(|schema, looked| {
            let wanted = looked.asked.elapsed() < PATIENCE;
            let mut slot = lock(&looked.slot);
            if wanted && slot.refused.is_some_and(|since| since.elapsed() > AGAIN) {
                slot.refused = None;
                let _ = questions.send((schema.clone(), looked.rate, Arc::clone(&looked.slot)));
            }
            wanted
        });
    }
}
