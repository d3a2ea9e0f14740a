//! Subscriptions to what windows requested lately, each at the highest rate requested lately. It does not know
//! what it receives.
//!
//! Subscribing waits for a reply of the application, so a separate thread does it.

use std::collections::HashMap;
use std::sync::mpsc::{Sender, channel};
use std::sync::{Arc, Weak};
use std::thread;
use std::time::{Duration, Instant};

use eframe::egui;
use jde_link::{Error, Rate, Subscription};
use parking_lot::{Mutex, MutexGuard};

use super::demand::Demand;

/// A failed subscription is retried after this time.
const RETRY_DELAY: Duration = Duration::from_secs(3);

/// Subscriptions by name.
pub(super) struct WatchList<T> {
    requests: Sender<Request<T>>,
    watched: HashMap<String, Watched<T>>,
}

type Request<T> = (String, Rate, Arc<Mutex<Slot<T>>>);

struct Watched<T> {
    rate: Rate,
    demand: Demand,
    slot: Arc<Mutex<Slot<T>>>,
}

/// What arrived of a subscription. Written by the link's threads.
#[derive(Default)]
pub(super) struct Slot<T> {
    pub(super) received: T,
    /// Why the last subscription failed, and when.
    failure: Option<(String, Instant)>,
    watching: Option<Subscription>,
}

/// The end of a subscription to which the link's threads write.
pub(super) struct Sink<T> {
    slot: Weak<Mutex<Slot<T>>>,
    repaint: egui::Context,
}

impl<T: Default + Send + 'static> WatchList<T> {
    /// Starts the thread of that name, which calls `subscribe`.
    pub(super) fn new(
        thread: &str,
        repaint: egui::Context,
        subscribe: impl Fn(&str, Rate, Sink<T>) -> Result<Subscription, Error> + Send + 'static,
    ) -> Self {
        let (requests, received) = channel::<Request<T>>();
        let worker = move || {
            for (name, rate, slot) in received {
                // It is no longer requested.
                if Arc::strong_count(&slot) == 1 {
                    continue;
                }
                let sink = Sink {
                    slot: Arc::downgrade(&slot),
                    repaint: repaint.clone(),
                };
                let watching = subscribe(&name, rate, sink);
                let mut slot = slot.lock();
                match watching {
                    Ok(watching) => (slot.watching, slot.failure) = (Some(watching), None),
                    Err(error) => slot.failure = Some((error.to_string(), Instant::now())),
                }
                repaint.request_repaint();
            }
        };
        // The thread ends when its sender is dropped, so its handle is not kept.
        if let Err(error) = thread::Builder::new().name(thread.to_owned()).spawn(worker) {
            tracing::error!("no thread for subscriptions: {error}");
        }
        Self {
            requests,
            watched: HashMap::new(),
        }
    }

    /// Requests a subscription at a rate, and returns what arrived of it.
    pub(super) fn request(&mut self, name: &str, rate: Rate) -> MutexGuard<'_, Slot<T>> {
        if self.watched.get(name).is_none_or(|watched| watched.rate < rate) {
            let watched = self.watched.entry(name.to_owned());
            watched
                .or_insert_with(|| Watched::new(rate))
                .subscribe(&self.requests, name, rate);
        }
        let watched = self
            .watched
            .get_mut(name)
            .expect("it exists or was just inserted");
        watched.demand.request(rate, Instant::now());
        watched.slot.lock()
    }

    /// Returns what arrived of a subscription, if there is one.
    pub(super) fn get(&self, name: &str) -> Option<MutexGuard<'_, Slot<T>>> {
        self.watched.get(name).map(|watched| watched.slot.lock())
    }

    /// Ends unused subscriptions, lowers rates that are higher than needed, and retries failed subscriptions.
    pub(super) fn remove_unused(&mut self) {
        let now = Instant::now();
        let requests = &self.requests;
        self.watched.retain(|name, watched| {
            let Some(rate) = watched.demand.greatest(now) else {
                return false;
            };
            if rate < watched.rate {
                watched.subscribe(requests, name, rate);
                return true;
            }
            let mut slot = watched.slot.lock();
            if let Some((_, since)) = &mut slot.failure
                && now.saturating_duration_since(*since) > RETRY_DELAY
            {
                *since = now;
                let _ = requests.send((name.clone(), rate, Arc::clone(&watched.slot)));
            }
            true
        });
    }
}

impl<T: Default> Watched<T> {
    fn new(rate: Rate) -> Self {
        Self {
            rate,
            demand: Demand::default(),
            slot: Arc::default(),
        }
    }

    /// Subscribes at a rate. What arrived so far is kept.
    fn subscribe(&mut self, requests: &Sender<Request<T>>, name: &str, rate: Rate) {
        let slot = Slot {
            received: std::mem::take(&mut self.slot.lock().received),
            ..Slot::default()
        };
        // The old slot is dropped, so its sink does nothing.
        self.slot = Arc::new(Mutex::new(slot));
        self.rate = rate;
        // Without the thread, the request is lost; the log has the reason.
        let _ = requests.send((name.to_owned(), rate, Arc::clone(&self.slot)));
    }
}

impl<T> Slot<T> {
    /// Why there is no subscription, if the application refused it.
    pub(super) fn failure(&self) -> Option<String> {
        self.failure.as_ref().map(|(failure, _)| failure.clone())
    }
}

impl<T> Sink<T> {
    /// Changes what arrived, and requests a frame. Does nothing once nobody reads it any more.
    pub(super) fn update(&self, change: impl FnOnce(&mut T)) {
        if let Some(slot) = self.slot.upgrade() {
            change(&mut slot.lock().received);
            self.repaint.request_repaint();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_change_of_the_rate_keeps_what_arrived() {
        let (requests, received) = channel();
        let mut watched = Watched::<Option<u32>>::new(Rate::Hz(5));
        watched.slot.lock().received = Some(7);
        let before = Arc::downgrade(&watched.slot);
        watched.subscribe(&requests, "a.b", Rate::Hz(50));
        assert!(before.upgrade().is_none(), "the old slot is dropped");
        let (name, rate, slot) = received.try_recv().expect("the subscription was requested");
        assert_eq!((name.as_str(), rate), ("a.b", Rate::Hz(50)));
        assert_eq!(slot.lock().received, Some(7));
    }
}
