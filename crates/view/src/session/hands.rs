//! Carries orders to the application and keeps its answers: on a thread of its own, in the order in which they were given.

use std::collections::{HashMap, HashSet, VecDeque};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::sync::{Arc, Mutex, OnceLock};
use std::thread;
use std::time::{Duration, Instant};

use eframe::egui;
use jde_link::Remote;
use jde_link::message::{Action, Request};
use jde_panel::Touch;

use super::{Notice, lock};

/// What is held and not asked for again for so long is let go.
const PATIENCE: Duration = Duration::from_millis(500);
/// How soon the application lets go by itself of what a dead viewer held.
const LEASE: Duration = Duration::from_millis(600);
/// A lease is renewed this often.
const RENEWED: Duration = Duration::from_millis(150);
/// How many answers are kept.
const KEPT: usize = 50;

pub(super) struct Hands {
    orders: Sender<Order>,
    notices: Arc<Mutex<Vec<Notice>>>,
}

/// What came of an order.
#[derive(Clone, Debug, Default)]
pub(crate) struct Outcome(Arc<OnceLock<Result<(), String>>>);

impl Outcome {
    /// It, or nothing while the order is under way.
    pub(crate) fn get(&self) -> Option<&Result<(), String>> {
        self.0.get()
    }
}

enum Order {
    Act(Action, Outcome),
    Hold(Action),
    LetGo(String),
}

impl Hands {
    pub(super) fn new(remote: Remote, repaint: egui::Context) -> Self {
        let (orders, taken) = channel();
        let notices = Arc::new(Mutex::new(Vec::new()));
        // A name of its own, so that letting go undoes nothing that this person did elsewhere.
        let holder = format!(
            "{} (view {:05})",
            jde_link::operator(),
            std::process::id() % 100_000
        );
        let worker = Worker {
            remote,
            holder,
            repaint,
            notices: Arc::clone(&notices),
            held: HashMap::new(),
        };
        // It ends when its sender is gone; there is nothing to wait for.
        let begun = thread::Builder::new()
            .name("view-hands".to_owned())
            .spawn(move || worker.run(&taken));
        if let Err(error) = begun {
            tracing::error!("no thread for orders: {error}");
        }
        Self { orders, notices }
    }

    pub(super) fn act(&self, action: Action) {
        self.order(action);
    }

    pub(super) fn order(&self, action: Action) -> Outcome {
        let outcome = Outcome::default();
        self.send(Order::Act(action, outcome.clone()));
        outcome
    }

    pub(super) fn hold(&self, action: Action) {
        self.send(Order::Hold(action));
    }

    pub(super) fn let_go(&self, schema: &str) {
        self.send(Order::LetGo(schema.to_owned()));
    }

    pub(super) fn notices(&self) -> Vec<Notice> {
        lock(&self.notices).clone()
    }

    fn send(&self, order: Order) {
        if self.orders.send(order).is_err() {
            let text = "orders cannot be carried any more: close this window and open it again".to_owned();
            note(&self.notices, text, true);
        }
    }
}

/// One that carries orders.
struct Worker {
    remote: Remote,
    holder: String,
    repaint: egui::Context,
    notices: Arc<Mutex<Vec<Notice>>>,
    held: HashMap<String, Held>,
}

/// What is held at a schema.
struct Held {
    action: Action,
    /// When a person asked for it last.
    asked: Instant,
    /// When the application heard of it last.
    told: Instant,
}

impl Worker {
    fn run(mut self, orders: &Receiver<Order>) {
        loop {
            let order = match self.next_end() {
                Some(end) => orders.recv_timeout(end.saturating_duration_since(Instant::now())),
                None => orders.recv().map_err(|_| RecvTimeoutError::Disconnected),
            };
            match order {
                Ok(order) => {
                    let mut waiting: VecDeque<_> = newest(order, orders).collect();
                    while let Some(order) = waiting.pop_front() {
                        match order {
                            Order::Act(action, _) if overtaken(&action, &waiting) => {}
                            Order::Act(action, outcome) => self.act(action, &outcome),
                            Order::Hold(action) => self.hold(action),
                            Order::LetGo(schema) => self.let_go(&schema),
                        }
                    }
                }
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => break,
            }
            let over: Vec<_> = self
                .held
                .iter()
                .filter(|(_, held)| held.asked.elapsed() >= PATIENCE)
                .map(|(schema, _)| schema.clone())
                .collect();
            over.iter().for_each(|schema| self.let_go(schema));
        }
        let rest: Vec<_> = self.held.keys().cloned().collect();
        rest.iter().for_each(|schema| self.let_go(schema));
    }

    fn next_end(&self) -> Option<Instant> {
        self.held.values().map(|held| held.asked + PATIENCE).min()
    }

    fn act(&mut self, action: Action, outcome: &Outcome) {
        let came = self.ask(jde_link::operator(), action, None);
        // Nobody else answers for it.
        let _ = outcome.0.set(came);
        self.repaint.request_repaint();
    }

    /// What changed is sent, what stays is renewed.
    fn hold(&mut self, action: Action) {
        let schema = action.schema().to_owned();
        let now = Instant::now();
        let order = match self.held.get_mut(&schema) {
            Some(held) if held.action == action => {
                held.asked = now;
                if held.told.elapsed() < RENEWED {
                    return;
                }
                match action {
                    // Written anew, so that its age tells whoever reads it that it is still wanted.
                    Action::Modulate { .. } => action.clone(),
                    _ => Action::Renew {
                        schema: schema.clone(),
                    },
                }
            }
            Some(_) | None => action.clone(),
        };
        if self.ask(self.holder.clone(), order, Some(LEASE)).is_ok() {
            let held = Held {
                action,
                asked: now,
                told: now,
            };
            self.held.insert(schema, held);
        } else {
            self.held.remove(&schema);
        }
    }

    fn let_go(&mut self, schema: &str) {
        if self.held.remove(schema).is_some() {
            let schema = schema.to_owned();
            // What came of it is among the notices.
            let _ = self.ask(self.holder.clone(), Action::LetGo { schema }, None);
        }
    }

    fn ask(&self, by: String, action: Action, lease: Option<Duration>) -> Result<(), String> {
        let request = Request {
            by,
            action,
            lease_ms: lease.map(|lease| lease.as_millis() as u64),
        };
        let answer = self.remote.operate(&request).map_err(|error| error.to_string());
        if let Err(error) = &answer {
            note(&self.notices, error.clone(), true);
        }
        self.repaint.request_repaint();
        answer
    }
}

/// Whether a slider or drag under way is followed by a newer one of the same: only the newest counts.
fn overtaken(action: &Action, later: &VecDeque<Order>) -> bool {
    let Action::Touch { schema, gesture } = action else {
        return false;
    };
    let next = later.iter().find_map(|order| match order {
        Order::Act(
            Action::Touch {
                schema: of,
                gesture: next,
            },
            _,
        ) => (of == schema && next.widget == gesture.widget).then_some(&next.touch),
        Order::Act(..) | Order::Hold(_) | Order::LetGo(_) => None,
    });
    match (&gesture.touch, next) {
        (Touch::Moved(_), Some(Touch::Moved(_))) => true,
        (
            Touch::Dragged {
                from, ended: false, ..
            },
            Some(Touch::Dragged { from: same, .. }),
        ) => from == same,
        _ => false,
    }
}

/// An order and those that wait behind it, without the holds that a later one at the same schema makes idle: where an answer takes
/// long, what a hand did meanwhile is not gone through step by step.
fn newest(first: Order, orders: &Receiver<Order>) -> impl Iterator<Item = Order> {
    let mut waiting: Vec<_> = std::iter::once(first).chain(orders.try_iter()).collect();
    let mut later = HashSet::new();
    // From the last to the first.
    waiting.reverse();
    waiting.retain(|order| match order {
        Order::Act(..) => true,
        Order::Hold(action) => later.insert(action.schema().to_owned()),
        Order::LetGo(schema) => {
            later.insert(schema.clone());
            true
        }
    });
    waiting.into_iter().rev()
}

fn note(notices: &Mutex<Vec<Notice>>, text: String, failed: bool) {
    let mut notices = lock(notices);
    // Said once, however often it is so.
    if let Some(last) = notices.last_mut()
        && last.text == text
        && last.failed == failed
    {
        last.at = Instant::now();
        return;
    }
    if notices.len() == KEPT {
        notices.remove(0);
    }
    notices.push(Notice {
        text,
        failed,
        at: Instant::now(),
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    fn hold(schema: &str, value: f64) -> Order {
        Order::Hold(Action::Modulate {
            schema: schema.to_owned(),
            variable: "want".to_owned(),
            value: value.into(),
        })
    }

    fn words(order: &Order) -> String {
        match order {
            Order::Act(action, _) => format!("act {}", action.schema()),
            Order::Hold(Action::Modulate { schema, value, .. }) => format!("hold {schema} {value}"),
            Order::Hold(action) => format!("hold {}", action.schema()),
            Order::LetGo(schema) => format!("let go {schema}"),
        }
    }

    #[test]
    fn of_holds_that_wait_the_last_at_each_schema_is_carried() {
        let (give, orders) = channel();
        for order in [
            hold("base", 2.0),
            hold("head", 1.0),
            Order::Act(
                Action::Play {
                    schema: "goon".to_owned(),
                },
                Outcome::default(),
            ),
            hold("base", 3.0),
            hold("head", 2.0),
            Order::LetGo("head".to_owned()),
        ] {
            give.send(order).expect("somebody listens");
        }
        let left: Vec<_> = newest(hold("base", 1.0), &orders)
            .map(|order| words(&order))
            .collect();
        assert_eq!(left, ["act goon", "hold base 3.0", "let go head"]);
        let left: Vec<_> = newest(hold("base", 1.0), &orders).collect();
        assert_eq!(left.len(), 1, "one alone stays");
    }

    #[test]
    fn a_hold_after_a_letting_go_is_carried_too() {
        let (give, orders) = channel();
        give.send(Order::LetGo("base".to_owned()))
            .expect("somebody listens");
        give.send(hold("base", 2.0)).expect("somebody listens");
        let left: Vec<_> = newest(hold("base", 1.0), &orders)
            .map(|order| words(&order))
            .collect();
        assert_eq!(left, ["let go base", "hold base 2.0"]);
    }
}
