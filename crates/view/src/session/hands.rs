//! Carries orders to the application and keeps its answers: on a thread of its own, in the order in which they were given.

use std::collections::HashMap;
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::sync::{Arc, Mutex};
use std::thread;
use std::time::{Duration, Instant};

use eframe::egui;
use jde_link::Remote;
use jde_link::message::{Action, Request};

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

enum Order {
    Act(Action),
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
        self.order(Order::Act(action));
    }

    pub(super) fn hold(&self, action: Action) {
        self.order(Order::Hold(action));
    }

    pub(super) fn let_go(&self, schema: &str) {
        self.order(Order::LetGo(schema.to_owned()));
    }

    pub(super) fn notices(&self) -> Vec<Notice> {
        lock(&self.notices).clone()
    }

    fn order(&self, order: Order) {
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
                Ok(Order::Act(action)) => self.act(action),
                Ok(Order::Hold(action)) => self.hold(action),
                Ok(Order::LetGo(schema)) => self.let_go(&schema),
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

    fn act(&mut self, action: Action) {
        self.ask(jde_link::operator(), action, None);
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
                Action::Renew {
                    schema: schema.clone(),
                }
            }
            Some(_) | None => action.clone(),
        };
        if self.ask(self.holder.clone(), order, Some(LEASE)) {
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
            self.ask(self.holder.clone(), Action::LetGo { schema }, None);
        }
    }

    fn ask(&self, by: String, action: Action, lease: Option<Duration>) -> bool {
        let request = Request {
            by,
            action,
            lease_ms: lease.map(|lease| lease.as_millis() as u64),
        };
        let answer = self.remote.operate(&request);
        if let Err(error) = &answer {
            note(&self.notices, error.to_string(), true);
        }
        self.repaint.request_repaint();
        answer.is_ok()
    }
}

fn note(notices: &Mutex<Vec<Notice>>, text: String, failed: bool) {
    let mut notices = lock(notices);
    if notices.len() == KEPT {
        notices.remove(0);
    }
    notices.push(Notice {
        text,
        failed,
        at: Instant::now(),
    });
}
