//! The variables that a window requested lately, each at the highest rate requested lately.
//!
//! Subscribing waits for a reply of the application, so a separate thread does it.

use std::collections::HashMap;
use std::sync::mpsc::{Sender, channel};
use std::sync::{Arc, Mutex};
use std::thread;
use std::time::{Duration, Instant};

use eframe::egui;
use jde_link::{Rate, Remote, Sample};

use super::backlog::Backlog;
use super::demand::{Demand, LastRequest};
use super::lock;

/// A failed subscription is retried after this time.
const RETRY_DELAY: Duration = Duration::from_secs(3);

pub(super) struct Subscriptions {
    requests: Sender<Request>,
    variables: HashMap<String, Subscription>,
}

type Request = (String, Rate, Arc<Mutex<Slot>>);

/// A subscription to a variable.
struct Subscription {
    rate: Rate,
    demand: Demand,
    slot: Arc<Mutex<Slot>>,
    /// Readers that need all values. Each has the values since its last call, and the time of that call.
    readers: HashMap<String, (Backlog, LastRequest)>,
}

/// Written by the link's threads.
#[derive(Default)]
struct Slot {
    newest: Option<Arc<Sample>>,
    /// Values since a reader last called, while there are readers.
    fresh: Option<Backlog>,
    trouble: Option<(String, Instant)>,
    watching: Option<jde_link::Subscription>,
}

impl Subscriptions {
    pub(super) fn new(remote: Remote, repaint: egui::Context) -> Self {
        let (requests, received) = channel::<Request>();
        let worker = move || {
            for (name, rate, slot) in received {
                // The variable is no longer requested.
                if Arc::strong_count(&slot) == 1 {
                    continue;
                }
                let (weak, repaint) = (Arc::downgrade(&slot), repaint.clone());
                let watching = remote.watch(&name, rate, move |sample| {
                    let Some(slot) = weak.upgrade() else { return };
                    lock(&slot).push(Arc::new(sample));
                    repaint.request_repaint();
                });
                let mut slot = lock(&slot);
                match watching {
                    Ok(watching) => (slot.watching, slot.trouble) = (Some(watching), None),
                    Err(error) => slot.trouble = Some((error.to_string(), Instant::now())),
                }
            }
        };
        if let Err(error) = thread::Builder::new()
            .name("view-subscribe".to_owned())
            .spawn(worker)
        {
            tracing::error!("no thread for subscriptions: {error}");
        }
        Self {
            requests,
            variables: HashMap::new(),
        }
    }

    pub(super) fn newest(&mut self, name: &str, rate: Rate) -> Option<Arc<Sample>> {
        let slot = Arc::clone(&self.variable(name, rate, Instant::now()).slot);
        lock(&slot).newest.clone()
    }

    pub(super) fn since(&mut self, name: &str, rate: Rate, reader: &str) -> Vec<Arc<Sample>> {
        let now = Instant::now();
        self.variable(name, rate, now).since(reader, now)
    }

    pub(super) fn trouble(&self, name: &str) -> Option<String> {
        let slot = lock(&self.variables.get(name)?.slot);
        slot.trouble.as_ref().map(|(trouble, _)| trouble.clone())
    }

    /// Ends unused subscriptions, lowers rates that are higher than needed, and retries failed subscriptions.
    pub(super) fn remove_unused(&mut self) {
        let now = Instant::now();
        let requests = &self.requests;
        self.variables.retain(|name, variable| {
            let Some(rate) = variable.demand.greatest(now) else {
                return false;
            };
            variable.remove_idle_readers(now);
            if rate < variable.rate {
                variable.subscribe(requests, name, rate);
                return true;
            }
            let mut slot = lock(&variable.slot);
            if let Some((_, since)) = &mut slot.trouble
                && now.saturating_duration_since(*since) > RETRY_DELAY
            {
                *since = now;
                let _ = requests.send((name.clone(), rate, Arc::clone(&variable.slot)));
            }
            true
        });
    }

    fn variable(&mut self, name: &str, rate: Rate, now: Instant) -> &mut Subscription {
        let sufficient = self
            .variables
            .get(name)
            .is_some_and(|variable| variable.rate >= rate);
        if !sufficient {
            let mut variable = self
                .variables
                .remove(name)
                .unwrap_or_else(|| Subscription::new(rate));
            variable.subscribe(&self.requests, name, rate);
            self.variables.insert(name.to_owned(), variable);
        }
        let variable = self
            .variables
            .get_mut(name)
            .expect("the variable exists or was just inserted");
        variable.demand.request(rate, now);
        variable
    }
}

impl Subscription {
    fn new(rate: Rate) -> Self {
        Self {
            rate,
            demand: Demand::default(),
            slot: Arc::default(),
            readers: HashMap::new(),
        }
    }

    /// Subscribes at a rate. The values received so far are kept.
    fn subscribe(&mut self, requests: &Sender<Request>, name: &str, rate: Rate) {
        let slot = {
            let mut before = lock(&self.slot);
            Slot {
                newest: before.newest.take(),
                fresh: before.fresh.take(),
                ..Slot::default()
            }
        };
        // The old slot is dropped, so its callback does nothing.
        self.slot = Arc::new(Mutex::new(slot));
        self.rate = rate;
        // Without the thread, the request is lost; the log has the reason.
        let _ = requests.send((name.to_owned(), rate, Arc::clone(&self.slot)));
    }

    /// The values since this reader's last call. The first call registers the reader.
    fn since(&mut self, reader: &str, now: Instant) -> Vec<Arc<Sample>> {
        if !self.readers.contains_key(reader) {
            self.readers
                .insert(reader.to_owned(), (Backlog::default(), LastRequest::new(now)));
        }
        let fresh = lock(&self.slot).fresh.get_or_insert_with(Backlog::default).take();
        for sample in fresh {
            for (backlog, _) in self.readers.values_mut() {
                backlog.push(Arc::clone(&sample));
            }
        }
        self.readers
            .get_mut(reader)
            .map(|(backlog, request)| {
                *request = LastRequest::new(now);
                backlog.take()
            })
            .unwrap_or_default()
    }

    /// Removes readers that stopped calling.
    fn remove_idle_readers(&mut self, now: Instant) {
        self.readers.retain(|_, (_, request)| request.check(now));
        if self.readers.is_empty() {
            lock(&self.slot).fresh = None;
        }
    }
}

impl Slot {
    fn push(&mut self, sample: Arc<Sample>) {
        if let Some(fresh) = &mut self.fresh {
            fresh.push(Arc::clone(&sample));
        }
        self.newest = Some(sample);
    }
}

#[cfg(test)]
pub(super) mod tests {
    use jde_types::Value as _;

    use super::super::demand::PATIENCE;
    use super::*;

    pub(in super::super) fn sample(sequence: u64, bytes: usize) -> Arc<Sample> {
        Arc::new(Sample {
            value_type: Arc::new(f64::describe()),
            bytes: Some(vec![0; bytes]),
            sequence,
            time: sequence,
            age: 0,
            valid_until: u64::MAX,
            writer: String::new(),
        })
    }

    #[test]
    fn a_reader_receives_every_value_once_and_an_idle_reader_is_removed() {
        let start = Instant::now();
        let mut variable = Subscription::new(Rate::Hz(50));
        let receive = |variable: &Subscription, number| lock(&variable.slot).push(sample(number, 8));
        let numbers = |samples: Vec<Arc<Sample>>| -> Vec<u64> {
            samples.iter().map(|sample| sample.sequence).collect()
        };
        receive(&variable, 1);
        assert!(
            lock(&variable.slot).fresh.is_none(),
            "without a reader, no values are kept"
        );
        assert!(numbers(variable.since("first", start)).is_empty());
        variable.since("second", start);
        (2..4).for_each(|number| receive(&variable, number));
        assert_eq!(numbers(variable.since("first", start)), [2, 3]);
        assert!(numbers(variable.since("first", start)).is_empty());
        assert_eq!(numbers(variable.since("second", start)), [2, 3]);

        let later = start + PATIENCE / 2;
        variable.remove_idle_readers(later);
        variable.since("first", later);
        receive(&variable, 4);
        variable.remove_idle_readers(start + PATIENCE);
        assert_eq!(variable.readers.keys().collect::<Vec<_>>(), ["first"]);
        assert_eq!(
            numbers(variable.since("first", later)),
            [4],
            "the remaining reader misses none"
        );
        variable.remove_idle_readers(later + PATIENCE);
        variable.remove_idle_readers(later + PATIENCE);
        receive(&variable, 5);
        assert!(variable.readers.is_empty() && lock(&variable.slot).fresh.is_none());
    }

    #[test]
    fn a_change_of_the_rate_keeps_the_newest_and_the_waiting_values() {
        let (requests, received) = channel();
        let mut variable = Subscription::new(Rate::Hz(5));
        variable.since("first", Instant::now());
        lock(&variable.slot).push(sample(1, 8));
        let before = Arc::downgrade(&variable.slot);
        variable.subscribe(&requests, "a.b", Rate::Hz(50));
        assert!(before.upgrade().is_none(), "the old slot is dropped");
        let (name, rate, slot) = received.try_recv().expect("the subscription was requested");
        assert_eq!((name.as_str(), rate), ("a.b", Rate::Hz(50)));
        assert!(lock(&slot).newest.is_some());
        drop(slot);
        assert_eq!(variable.since("first", Instant::now()).len(), 1);
    }
}
