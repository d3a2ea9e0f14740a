//! Sends an order to the application and records its outcome. Each call waits for the reply: not for the
//! window's thread.

use std::sync::{Arc, OnceLock};
use std::time::{Duration, Instant};

use eframe::egui;
use jde_link::Remote;
use jde_link::message::{Action, Request};
use parking_lot::Mutex;

use crate::stop::StopRequest;

/// Maximum number of notices kept.
const MAX_NOTICES: usize = 50;

/// Why an order failed.
#[derive(Clone, Debug)]
pub(crate) struct Notice {
    /// The message.
    pub(crate) text: String,
    /// When the order last failed for this reason.
    pub(crate) at: Instant,
}

/// The outcome of an order.
#[derive(Clone, Debug, Default)]
pub(crate) struct OrderOutcome(Arc<OnceLock<Result<(), String>>>);

impl OrderOutcome {
    /// The outcome. `None` while the order is in progress, and forever if a newer order replaced it.
    pub(crate) fn get(&self) -> Option<&Result<(), String>> {
        self.0.get()
    }

    pub(crate) fn set(&self, result: Result<(), String>) {
        // Each order has one outcome, so the cell is empty.
        let _ = self.0.set(result);
    }
}

/// The connection to the application for orders, and the notices of failed ones.
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

    /// The notices of failed orders, newest last.
    pub(super) fn notices(&self) -> Vec<Notice> {
        self.notices.lock().clone()
    }

    /// Adds a notice.
    pub(super) fn note(&self, text: String) {
        if note(&mut self.notices.lock(), text) {
            self.repaint.request_repaint();
        }
    }

    /// Sends an action once, as this machine's user, and sets its outcome.
    pub(super) fn act(&self, action: Action, outcome: &OrderOutcome) {
        outcome.set(self.request(jde_link::operator(), action, None));
        self.repaint.request_repaint();
    }

    /// Stops everything, and returns once that is acknowledged or withdrawn.
    pub(super) fn stop_everything(&self, request: &StopRequest) {
        request.ask_application(&self.remote, &|| self.repaint.request_repaint());
    }

    /// Sends a request. Adds a notice if it fails.
    pub(super) fn request(&self, by: String, action: Action, lease: Option<Duration>) -> Result<(), String> {
        let request = Request {
            by,
            action,
            lease_ms: lease.map(|lease| lease.as_millis() as u64),
        };
        let reply = self.remote.operate(&request).map_err(|error| error.to_string());
        if let Err(error) = &reply {
            self.note(error.clone());
        }
        reply
    }
}

/// Adds a notice. Returns whether it differs from the last one.
fn note(notices: &mut Vec<Notice>, text: String) -> bool {
    // A repeated failure only renews the time of its notice.
    if let Some(last) = notices.last_mut()
        && last.text == text
    {
        last.at = Instant::now();
        return false;
    }
    if notices.len() == MAX_NOTICES {
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
    fn a_repeated_failure_is_one_notice_and_the_list_is_bounded() {
        let mut notices = Vec::new();
        assert!(note(&mut notices, "refused".to_owned()));
        assert!(!note(&mut notices, "refused".to_owned()));
        assert_eq!(notices.len(), 1);
        for number in 0..2 * MAX_NOTICES {
            assert!(note(&mut notices, number.to_string()));
        }
        assert_eq!(notices.len(), MAX_NOTICES);
        assert_eq!(notices[MAX_NOTICES - 1].text, (2 * MAX_NOTICES - 1).to_string());
    }
}
