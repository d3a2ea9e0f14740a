//! Says an order to the application, and keeps what came of it. It waits for the answer: not for the window's thread.

use std::sync::{Arc, Mutex, OnceLock};
use std::time::{Duration, Instant};

use eframe::egui;
use jde_link::Remote;
use jde_link::message::{Action, Request};

use super::lock;

/// How many notices are kept.
const KEPT: usize = 50;

/// Why something that was asked of the application came to nothing.
#[derive(Clone, Debug)]
pub(crate) struct Notice {
    /// In words.
    pub(crate) text: String,
    /// When it was known.
    pub(crate) at: Instant,
}

/// What came of an order.
#[derive(Clone, Debug, Default)]
pub(crate) struct Outcome(Arc<OnceLock<Result<(), String>>>);

impl Outcome {
    /// It, or nothing while the order is under way or if a newer one overtook it.
    pub(crate) fn get(&self) -> Option<&Result<(), String>> {
        self.0.get()
    }

    pub(super) fn set(&self, came: Result<(), String>) {
        // Nobody else answers for it.
        let _ = self.0.set(came);
    }
}

/// The way to the application, and what it answered.
#[derive(Clone)]
pub(super) struct OrderClient {
    remote: Remote,
    repaint: egui::Context,
    notices: Arc<Mutex<Vec<Notice>>>,
}

impl OrderClient {
    pub(super) fn new(remote: Remote, repaint: egui::Context) -> Self {
        Self {
            remote,
            repaint,
            notices: Arc::default(),
        }
    }

    /// Why orders came to nothing lately, newest last.
    pub(super) fn notices(&self) -> Vec<Notice> {
        lock(&self.notices).clone()
    }

    /// Says that an order came to nothing.
    pub(super) fn note(&self, text: String) {
        if note(&mut lock(&self.notices), text) {
            self.repaint.request_repaint();
        }
    }

    /// Once, as the person at this machine.
    pub(super) fn act(&self, action: Action, outcome: &Outcome) {
        outcome.set(self.request(jde_link::operator(), action, None));
        self.repaint.request_repaint();
    }

    /// Asks, and notes what was refused.
    pub(super) fn request(&self, by: String, action: Action, lease: Option<Duration>) -> Result<(), String> {
        let request = Request {
            by,
            action,
            lease_ms: lease.map(|lease| lease.as_millis() as u64),
        };
        let answer = self.remote.operate(&request).map_err(|error| error.to_string());
        if let Err(error) = &answer {
            self.note(error.clone());
        }
        answer
    }
}

/// Notes that something failed; answers whether that is news.
fn note(notices: &mut Vec<Notice>, text: String) -> bool {
    // Said once, however often it is so.
    if let Some(last) = notices.last_mut()
        && last.text == text
    {
        last.at = Instant::now();
        return false;
    }
    if notices.len() == KEPT {
        notices.remove(0);
    }
    notices.push(Notice {
        text,
        at: Instant::now(),
    });
    true
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_fails_again_and_again_is_news_once_and_the_list_is_bounded() {
        let mut notices = Vec::new();
        assert!(note(&mut notices, "refused".to_owned()));
        assert!(!note(&mut notices, "refused".to_owned()));
        assert_eq!(notices.len(), 1);
        for number in 0..2 * KEPT {
            assert!(note(&mut notices, number.to_string()));
        }
        assert_eq!(notices.len(), KEPT);
        assert_eq!(notices[KEPT - 1].text, (2 * KEPT - 1).to_string());
    }
}
