//! One order to stop everything (R14), from the press of the button until everyone has acknowledged it. It goes on
//! asking meanwhile, unless the person withdraws it or orders the same again. It lets nothing go on.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::{Duration, Instant};

use jde_link::message::{Action, Request};
use jde_link::{Broadcast, Error, Reach, Remote};
use parking_lot::{Condvar, Mutex};

/// Pause between two rounds. A round itself takes up to some seconds, where nobody answers.
const ROUND_PAUSE: Duration = Duration::from_millis(200);

/// Whom it asks.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum StopTarget {
    /// The application of this name, and `@` with the beginning of its id.
    One(String),
    /// All applications in reach.
    All,
}

/// An order to stop everything.
#[derive(Debug)]
pub(crate) struct StopRequest {
    pub(crate) target: StopTarget,
    reach: Reach,
    /// When it was first pressed.
    pub(crate) since: Instant,
    answers: Mutex<Answers>,
    changed: Condvar,
}

/// What has been answered so far.
#[derive(Clone, Debug, Default)]
pub(crate) struct Answers {
    /// Those that have not acknowledged it, and the last reason if there is one.
    pub(crate) missing: BTreeMap<String, Option<String>>,
    /// Those that have.
    pub(crate) stopped: Vec<String>,
    /// When all had acknowledged it.
    pub(crate) acknowledged: Option<Instant>,
    withdrawn: bool,
}

impl StopRequest {
    /// Begins an order that these applications are known to have to acknowledge.
    pub(crate) fn new(target: StopTarget, reach: Reach, since: Instant, names: Vec<String>) -> Arc<Self> {
        let missing = names.into_iter().map(|name| (name, None)).collect();
        Arc::new(Self {
            target,
            reach,
            since,
            answers: Mutex::new(Answers {
                missing,
                ..Answers::default()
            }),
            changed: Condvar::new(),
        })
    }

    /// The answers so far.
    pub(crate) fn answers(&self) -> Answers {
        self.answers.lock().clone()
    }

    /// Whether it still asks.
    pub(crate) fn is_pending(&self) -> bool {
        let answers = self.answers.lock();
        answers.acknowledged.is_none() && !answers.withdrawn
    }

    /// Ends it: the person said otherwise, or the same was ordered again.
    pub(crate) fn withdraw(&self) {
        self.answers.lock().withdrawn = true;
        self.changed.notify_all();
    }

    /// Records that nobody asks, and why.
    pub(crate) fn fail(&self, reason: String) {
        for missing in self.answers.lock().missing.values_mut() {
            *missing = Some(reason.clone());
        }
    }

    /// Asks everyone in reach until all have acknowledged it. Blocks.
    pub(crate) fn ask_in_reach(&self, repaint: &dyn Fn()) {
        let broadcast = Broadcast::default();
        self.ask(repaint, || self.send(&broadcast));
    }

    /// Asks the application of a window until it has acknowledged it. Blocks. Once its connection is lost, asks over a new
    /// one: on this machine every run of its name, since a new run may have the robot.
    pub(crate) fn ask_application(&self, remote: &Remote, repaint: &dyn Fn()) {
        let name = &remote.about().name;
        let broadcast = Broadcast::default();
        self.ask(repaint, || {
            if !remote.is_alive() {
                return self.send(&broadcast);
            }
            match remote.operate(&stop_all()) {
                Ok(()) => {
                    self.answers.lock().stopped.push(name.clone());
                    true
                }
                Err(error) => {
                    self.answers
                        .lock()
                        .missing
                        .insert(name.clone(), Some(error.to_string()));
                    false
                }
            }
        });
    }

    /// Repeats `round` until it returns that all have acknowledged the order, or the order ends otherwise.
    fn ask(&self, repaint: &dyn Fn(), mut round: impl FnMut() -> bool) {
        while self.is_pending() {
            let done = round();
            let mut answers = self.answers.lock();
            if done {
                answers.missing.clear();
                answers.acknowledged = Some(Instant::now());
            }
            let waits = |answers: &mut Answers| answers.acknowledged.is_none() && !answers.withdrawn;
            self.changed.wait_while_for(&mut answers, waits, ROUND_PAUSE);
            drop(answers);
            repaint();
        }
    }

    /// One round over new connections. Returns whether all have acknowledged it by now.
    fn send(&self, broadcast: &Broadcast) -> bool {
        let name = match (&self.target, &self.reach) {
            (StopTarget::All, _) => None,
            (StopTarget::One(name), Reach::Network { .. }) => Some(name.as_str()),
            (StopTarget::One(name), Reach::Local(_)) => name.split('@').next(),
        };
        let mut failed = false;
        let sent = broadcast.send(&self.reach, name, &stop_all(), &mut |reply| {
            let mut answers = self.answers.lock();
            match reply.outcome {
                Ok(_) => {
                    answers.missing.remove(&reply.target);
                    answers.stopped.push(reply.target);
                }
                Err(error) => {
                    failed = true;
                    answers.missing.insert(reply.target, Some(error.to_string()));
                }
            }
        });
        match (sent, &self.target) {
            (Ok(()), _) => !failed,
            // There is nothing to stop.
            (Err(Error::NoApplication(_) | Error::OnlyRecordings), StopTarget::All) => true,
            (Err(error), StopTarget::All) => {
                let whereabouts = "the search for applications".to_owned();
                self.answers
                    .lock()
                    .missing
                    .insert(whereabouts, Some(error.to_string()));
                false
            }
            (Err(error), StopTarget::One(_)) => {
                self.fail(error.to_string());
                false
            }
        }
    }
}

fn stop_all() -> Request {
    Request {
        by: jde_link::operator(),
        action: Action::StopAll,
        lease_ms: None,
    }
}
