//! The panels that a window requested lately. A schema draws its panel only for these.
//!
//! Subscribing waits for a reply of the application, so a separate thread does it.

use std::collections::HashMap;
use std::sync::mpsc::{Sender, channel};
use std::sync::{Arc, Mutex};
use std::thread;
use std::time::{Duration, Instant};

use eframe::egui;
use jde_link::{Rate, Remote, Subscription};
use jde_panel::List;

use super::demand::Demand;
use super::lock;

/// A failed subscription is retried after this time.
const RETRY_DELAY: Duration = Duration::from_secs(3);

/// The newest list of a panel, or why there is none.
pub(crate) type PanelContent = Result<Arc<List>, String>;

pub(super) struct Panels {
    requests: Sender<Request>,
    watched: HashMap<String, WatchedPanel>,
}

type Request = (String, Rate, Arc<Mutex<Slot>>);

struct WatchedPanel {
    rate: Rate,
    demand: Demand,
    slot: Arc<Mutex<Slot>>,
}

/// Written by the link's threads.
#[derive(Default)]
struct Slot {
    newest: Option<PanelContent>,
    refused: Option<Instant>,
    watching: Option<Subscription>,
}

impl Panels {
    pub(super) fn new(remote: Remote, repaint: egui::Context) -> Self {
        let (requests, received) = channel::<Request>();
        let worker = move || {
            for (schema, rate, slot) in received {
                // The panel is no longer requested.
                if Arc::strong_count(&slot) == 1 {
                    continue;
                }
                let (weak, again) = (Arc::downgrade(&slot), repaint.clone());
                let watching = remote.watch_panel(&schema, rate, move |panel| {
                    let Some(slot) = weak.upgrade() else { return };
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
        // The thread ends when its sender is dropped, so its handle is not kept.
        if let Err(error) = thread::Builder::new()
            .name("view-panels".to_owned())
            .spawn(worker)
        {
            tracing::error!("no thread for panels: {error}");
        }
        Self {
            requests,
            watched: HashMap::new(),
        }
    }

    pub(super) fn newest(&mut self, schema: &str, rate: Rate) -> Option<PanelContent> {
        let watched = match self.watched.get_mut(schema) {
            Some(watched) => watched,
            None => {
                let mut watched = WatchedPanel::new(rate);
                watched.subscribe(&self.requests, schema, rate);
                self.watched.entry(schema.to_owned()).or_insert(watched)
            }
        };
        if watched.rate < rate {
            watched.subscribe(&self.requests, schema, rate);
        }
        watched.demand.request(rate, Instant::now());
        lock(&watched.slot).newest.clone()
    }

    /// Ends unused subscriptions, lowers rates that are higher than needed, and retries refused
    /// subscriptions.
    pub(super) fn remove_unused(&mut self) {
        let now = Instant::now();
        let requests = &self.requests;
        self.watched.retain(|schema, watched| {
            let Some(rate) = watched.demand.greatest(now) else {
                return false;
            };
            if rate < watched.rate {
                watched.subscribe(requests, schema, rate);
                return true;
            }
            let mut slot = lock(&watched.slot);
            if slot
                .refused
                .is_some_and(|since| now.saturating_duration_since(since) > RETRY_DELAY)
            {
                slot.refused = None;
                let _ = requests.send((schema.clone(), rate, Arc::clone(&watched.slot)));
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

    /// Subscribes at a rate. The newest list is kept until the next arrives.
    fn subscribe(&mut self, requests: &Sender<Request>, schema: &str, rate: Rate) {
        let newest = lock(&self.slot).newest.take();
        // The old slot is dropped, so its callback does nothing.
        self.slot = Arc::new(Mutex::new(Slot {
            newest,
            ..Slot::default()
        }));
        self.rate = rate;
        // Without the thread, the request is lost; the log has the reason.
        let _ = requests.send((schema.to_owned(), rate, Arc::clone(&self.slot)));
    }
}
