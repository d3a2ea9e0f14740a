//! The variables that are listened to: those that a window asked for lately, each at the highest rate it was asked for.
//!
//! Listening begins with a question to the application, which a thread of its own asks.

use std::collections::{HashMap, VecDeque};
use std::sync::mpsc::{Sender, channel};
use std::sync::{Arc, Mutex};
use std::thread;
use std::time::{Duration, Instant};

use eframe::egui;
use jde_link::{Rate, Remote, Sample, Watching};

use super::lock;

/// What nobody asks for any more is let go after so long.
const PATIENCE: Duration = Duration::from_secs(2);
/// What failed is tried again after so long.
const AGAIN: Duration = Duration::from_secs(3);
/// Values that wait for a frame.
const WAITING: usize = 4096;

pub(super) struct Watched {
    questions: Sender<(String, Rate, Arc<Mutex<Slot>>)>,
    variables: HashMap<String, Variable>,
}

struct Variable {
    rate: Rate,
    asked: Instant,
    slot: Arc<Mutex<Slot>>,
    readers: HashMap<String, VecDeque<Arc<Sample>>>,
}

/// What the link's threads fill.
#[derive(Default)]
struct Slot {
    newest: Option<Arc<Sample>>,
    /// Since the last look, if somebody wants all of them.
    fresh: VecDeque<Arc<Sample>>,
    keep: bool,
    trouble: Option<(String, Instant)>,
    watching: Option<Watching>,
}

impl Watched {
    pub(super) fn new(remote: Remote, repaint: egui::Context) -> Self {
        let (questions, asked) = channel::<(String, Rate, Arc<Mutex<Slot>>)>();
        let eyes = move || {
            for (name, rate, slot) in asked {
                // Nobody wants it any more.
                if Arc::strong_count(&slot) == 1 {
                    continue;
                }
                let (heard, repaint) = (Arc::downgrade(&slot), repaint.clone());
                let watching = remote.watch(&name, rate, move |sample| {
                    let Some(slot) = heard.upgrade() else { return };
                    let mut slot = lock(&slot);
                    let sample = Arc::new(sample);
                    if slot.keep {
                        if slot.fresh.len() == WAITING {
                            slot.fresh.pop_front();
                        }
                        slot.fresh.push_back(Arc::clone(&sample));
                    }
                    slot.newest = Some(sample);
                    repaint.request_repaint();
                });
                let mut slot = lock(&slot);
                match watching {
                    Ok(watching) => (slot.watching, slot.trouble) = (Some(watching), None),
                    Err(error) => slot.trouble = Some((error.to_string(), Instant::now())),
                }
            }
        };
        if let Err(error) = thread::Builder::new().name("view-eyes".to_owned()).spawn(eyes) {
            tracing::error!("no thread for questions: {error}");
        }
        Self {
            questions,
            variables: HashMap::new(),
        }
    }

    pub(super) fn newest(&mut self, name: &str, rate: Rate) -> Option<Arc<Sample>> {
        let slot = Arc::clone(&self.variable(name, rate).slot);
        lock(&slot).newest.clone()
    }

    pub(super) fn since(&mut self, name: &str, rate: Rate, reader: &str) -> Vec<Arc<Sample>> {
        let variable = self.variable(name, rate);
        let fresh = {
            let mut slot = lock(&variable.slot);
            slot.keep = true;
            std::mem::take(&mut slot.fresh)
        };
        if !variable.readers.contains_key(reader) {
            variable.readers.insert(reader.to_owned(), VecDeque::new());
        }
        for waiting in variable.readers.values_mut() {
            waiting.extend(fresh.iter().cloned());
            let surplus = waiting.len().saturating_sub(WAITING);
            waiting.drain(..surplus);
        }
        variable
            .readers
            .get_mut(reader)
            .map(std::mem::take)
            .unwrap_or_default()
            .into()
    }

    pub(super) fn trouble(&self, name: &str) -> Option<String> {
        let slot = lock(&self.variables.get(name)?.slot);
        slot.trouble.as_ref().map(|(trouble, _)| trouble.clone())
    }

    /// Lets go of what nobody asks for any more, and tries again what failed.
    pub(super) fn tidy(&mut self) {
        let questions = &self.questions;
        self.variables.retain(|name, variable| {
            let wanted = variable.asked.elapsed() < PATIENCE;
            let mut slot = lock(&variable.slot);
            if let Some((_, since)) = &mut slot.trouble
                && wanted
                && since.elapsed() > AGAIN
            {
                *since = Instant::now();
                let _ = questions.send((name.clone(), variable.rate, Arc::clone(&variable.slot)));
            }
            wanted
        });
    }

    fn variable(&mut self, name: &str, rate: Rate) -> &mut Variable {
        let known = self
            .variables
            .get(name)
            .is_some_and(|variable| variable.rate >= rate);
        if !known {
            // What came at a lower rate is shown until more comes.
            let before = self.variables.remove(name);
            let slot = Arc::new(Mutex::new(Slot::default()));
            let mut readers = HashMap::new();
            if let Some(before) = before {
                let mut old = lock(&before.slot);
                let mut new = lock(&slot);
                (new.newest, new.keep) = (old.newest.take(), old.keep);
                new.fresh = std::mem::take(&mut old.fresh);
                readers = before.readers;
            }
            let _ = self.questions.send((name.to_owned(), rate, Arc::clone(&slot)));
            let variable = Variable {
                rate,
                asked: Instant::now(),
                slot,
                readers,
            };
            self.variables.insert(name.to_owned(), variable);
        }
        let variable = self
            .variables
            .get_mut(name)
            .expect("it was there or has just been put there");
        variable.asked = Instant::now();
        variable
    }
}
