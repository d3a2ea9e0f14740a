//! The hold that manual driving has on one schema: it is renewed while the control is held, and released at
//! once afterwards.

use std::time::{Duration, Instant};

use eframe::egui::Ui;
use jde_link::message::Action;
use serde_json::Value;

use crate::session::WindowSession;

/// Minimum interval between changes of the wanted value, and the interval of its renewal. A base ignores
/// faster changes, and the renewal is well within the patience of the driven schema.
pub(super) const BEAT: Duration = Duration::from_millis(40);

/// The hold on one schema.
#[derive(Default)]
pub(super) struct DriveLease {
    held: Option<LeasedValue>,
}

struct LeasedValue {
    schema: String,
    want: Value,
    since: Instant,
}

impl DriveLease {
    /// Whether a value is held.
    pub(super) fn holds(&self) -> bool {
        self.held.is_some()
    }

    /// Holds the wanted value, or releases the hold if `want` is `None`.
    pub(super) fn order(&mut self, ui: &Ui, session: &WindowSession, schema: &str, want: Option<Value>) {
        let Some(want) = want else {
            self.let_go(session);
            return;
        };
        if self.held.as_ref().is_some_and(|held| held.schema != schema) {
            self.let_go(session);
        }
        let new = |held: &LeasedValue| held.want != want && held.since.elapsed() >= BEAT;
        if self.held.as_ref().is_none_or(new) {
            self.held = Some(LeasedValue {
                schema: schema.to_owned(),
                want,
                since: Instant::now(),
            });
        }
        if let Some(held) = &self.held {
            session.hold(Action::Modulate {
                schema: held.schema.clone(),
                variable: "want".to_owned(),
                value: held.want.clone(),
            });
        }
        ui.ctx().request_repaint_after(BEAT);
    }

    pub(super) fn let_go(&mut self, session: &WindowSession) {
        if let Some(held) = self.held.take() {
            session.let_go(&held.schema);
        }
    }
}
