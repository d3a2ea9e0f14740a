//! Sends orders to the application in sequence, on separate threads, and records the outcomes. Stops have
//! their own thread, because an order without a reply takes seconds.

use std::collections::HashMap;
use std::sync::Arc;
use std::thread;
use std::time::{Duration, Instant};

use eframe::egui;
use jde_link::Remote;
use jde_link::message::Action;
use parking_lot::{Condvar, Mutex};

use super::client::{Notice, OrderClient, OrderOutcome};
use super::queue::{Next, Order, Queue, Stop};
use crate::stop::StopRequest;

/// A hold that is not renewed for this time is released.
pub(super) const PATIENCE: Duration = Duration::from_millis(500);
/// The lease of a hold: after this time without renewal, as of a dead viewer, the application releases it.
const HOLD_LEASE: Duration = Duration::from_millis(600);
/// Interval between renewals of a lease, and between retries of a refused hold.
const RENEWAL_INTERVAL: Duration = Duration::from_millis(150);

pub(super) struct Orders {
    orders: Arc<OrderInbox>,
    client: OrderClient,
}

impl Orders {
    pub(super) fn new(remote: Remote, repaint: egui::Context) -> Self {
        let orders = Arc::new(OrderInbox::default());
        let client = OrderClient::new(remote, repaint);
        let worker = Worker {
            orders: Arc::clone(&orders),
            client: client.clone(),
            // A separate name, so that the release undoes nothing that this user did elsewhere.
            holder: format!(
                "{} (view {:05})",
                jde_link::operator(),
                std::process::id() % 100_000
            ),
            held: HashMap::new(),
            refused: HashMap::new(),
        };
        let (stops, stopper) = (Arc::clone(&orders), client.clone());
        // The threads end when the inbox is closed, so their handles are dropped.
        for (name, work) in [
            (
                "view-orders",
                Box::new(move || worker.run()) as Box<dyn FnOnce() + Send>,
            ),
            ("view-stop", Box::new(move || stop(&stops, &stopper))),
        ] {
            if let Err(error) = thread::Builder::new().name(name.to_owned()).spawn(work) {
                client.note(format!(
                    "orders cannot be sent, because there is no thread for them: {error}"
                ));
            }
        }
        Self { orders, client }
    }

    pub(super) fn act(&self, action: Action) {
        self.order(action);
    }

    pub(super) fn order(&self, action: Action) -> OrderOutcome {
        let outcome = OrderOutcome::default();
        self.orders.push(Order::Act(action, outcome.clone()));
        outcome
    }

    pub(super) fn stop_everything(&self, request: Arc<StopRequest>) {
        self.orders.push(Order::StopEverything(request));
    }

    pub(super) fn hold(&self, action: Action) {
        self.orders.push(Order::Hold(action));
    }

    pub(super) fn let_go(&self, schema: &str) {
        self.orders.push(Order::LetGo(schema.to_owned()));
    }

    pub(super) fn notices(&self) -> Vec<Notice> {
        self.client.notices()
    }
}

impl Drop for Orders {
    fn drop(&mut self) {
        self.orders.close();
    }
}

/// The orders between the window's thread, which adds them, and the threads that send them.
#[derive(Default)]
struct OrderInbox {
    state: Mutex<InboxState>,
    changed: Condvar,
}

#[derive(Default)]
struct InboxState {
    queue: Queue,
    /// No more orders are added.
    closed: bool,
}

impl OrderInbox {
    fn push(&self, order: Order) {
        self.state.lock().queue.push(order, Instant::now());
        self.changed.notify_all();
    }

    fn close(&self) {
        self.state.lock().closed = true;
        self.changed.notify_all();
    }

    /// Waits for the next order other than a stop. Returns [`Received::Time`] at `until`, and
    /// [`Received::Closed`] once closed and all orders, stops included, are sent.
    fn next(&self, until: Option<Instant>) -> Received {
        let mut state = self.state.lock();
        loop {
            let now = Instant::now();
            let earliest = match state.queue.next(now) {
                Next::Send(order, given) => return Received::Send(order, given),
                Next::Stale(action, outcome) => return Received::Stale(action, outcome),
                Next::Wait(earliest) => earliest,
            };
            if state.closed && state.queue.is_empty() {
                return Received::Closed;
            }
            if until.is_some_and(|until| until <= now) {
                return Received::Time;
            }
            let deadline = earliest.into_iter().chain(until).min();
            match deadline {
                Some(deadline) => {
                    let pause = deadline.saturating_duration_since(now);
                    self.changed.wait_for(&mut state, pause);
                }
                None => self.changed.wait(&mut state),
            }
        }
    }

    /// Waits for the next stop. Returns `None` once closed and no stop is left.
    fn next_stop(&self) -> Option<Stop> {
        let mut state = self.state.lock();
        loop {
            if let Some(stop) = state.queue.next_stop() {
                return Some(stop);
            }
            if state.closed {
                return None;
            }
            self.changed.wait(&mut state);
        }
    }

    fn stopped(&self) {
        self.state.lock().queue.stopped();
        self.changed.notify_all();
    }
}

/// The result of waiting for an order.
enum Received {
    Send(Order, Instant),
    Stale(Action, OrderOutcome),
    Time,
    Closed,
}

/// Sends stops. Body of the thread `view-stop`.
fn stop(orders: &OrderInbox, client: &OrderClient) {
    while let Some(stop) = orders.next_stop() {
        match stop {
            Stop::Schema(action, outcome) => client.act(action, &outcome),
            Stop::Everything(request) => client.stop_everything(&request),
        }
        orders.stopped();
    }
}

/// Sends all other orders, on the thread `view-orders`.
struct Worker {
    orders: Arc<OrderInbox>,
    client: OrderClient,
    holder: String,
    held: HashMap<String, Lease>,
    /// When each schema last refused to be held.
    refused: HashMap<String, Instant>,
}

/// A hold on a schema.
struct Lease {
    action: Action,
    /// When the user last requested it.
    requested: Instant,
    /// When it was last sent to the application.
    sent: Instant,
}

impl Worker {
    fn run(mut self) {
        loop {
            let deadline = self.held.values().map(|held| held.requested + PATIENCE).min();
            match self.orders.next(deadline) {
                Received::Send(Order::Act(action, outcome), _) => self.client.act(action, &outcome),
                Received::Send(Order::Hold(action), given) => self.hold(action, given),
                Received::Send(Order::LetGo(schema), _) => self.let_go(&schema),
                // The queue gives these to the other thread.
                Received::Send(Order::StopEverything(request), _) => self.client.stop_everything(&request),
                Received::Stale(action, outcome) => self.give_up(&action, &outcome),
                Received::Time => {}
                Received::Closed => break,
            }
            let expired: Vec<_> = self
                .held
                .iter()
                .filter(|(_, held)| held.requested.elapsed() >= PATIENCE)
                .map(|(schema, _)| schema.clone())
                .collect();
            expired.iter().for_each(|schema| self.let_go(schema));
        }
        let remaining: Vec<_> = self.held.keys().cloned().collect();
        remaining.iter().for_each(|schema| self.let_go(schema));
    }

    /// Sends a new or changed hold, and renews an unchanged one. Skips a schema that refused within
    /// [`RENEWAL_INTERVAL`].
    fn hold(&mut self, action: Action, requested: Instant) {
        let schema = action.schema().to_owned();
        self.refused.retain(|_, when| when.elapsed() < RENEWAL_INTERVAL);
        if self.refused.contains_key(&schema) {
            return;
        }
        let order = match self.held.get_mut(&schema) {
            Some(held) if held.action == action => {
                held.requested = requested;
                if held.sent.elapsed() < RENEWAL_INTERVAL {
                    return;
                }
                match action {
                    // Written anew, so that its age shows readers that it is still wanted.
                    Action::Modulate { .. } => action.clone(),
                    _ => Action::Renew {
                        schema: schema.clone(),
                    },
                }
            }
            Some(_) | None => action.clone(),
        };
        let sent = Instant::now();
        if self
            .client
            .request(self.holder.clone(), order, Some(HOLD_LEASE))
            .is_ok()
        {
            let held = Lease {
                action,
                requested,
                sent,
            };
            self.held.insert(schema, held);
        } else {
            self.held.remove(&schema);
            self.refused.insert(schema, Instant::now());
        }
    }

    fn let_go(&mut self, schema: &str) {
        if self.held.remove(schema).is_some() {
            let schema = schema.to_owned();
            // A failure is already among the notices.
            let _ = self
                .client
                .request(self.holder.clone(), Action::LetGo { schema }, None);
        }
    }

    /// Sets the outcome of an order that was not sent, and adds a notice.
    fn give_up(&self, action: &Action, outcome: &OrderOutcome) {
        let purpose = match action.schema() {
            "" => "to resume everything".to_owned(),
            schema => format!("for {schema}"),
        };
        let text = format!(
            "an order {purpose} was discarded, because the application was too slow to accept it; repeat it"
        );
        outcome.set(Err(text.clone()));
        self.client.note(text);
    }
}
