//! What a hand holds of one schema: ordered again and again for as long as it is held, and let go of at once.

use std::time::{Duration, Instant};

use eframe::egui::Ui;
use jde_link::message::Action;
use serde_json::Value;

use crate::session::Session;

/// What is wanted is changed no more often, a robot's base takes no notice of more; and it is told of as often, well within the
/// patience of a schema that is driven.
pub(super) const BEAT: Duration = Duration::from_millis(40);

/// What a hand holds of one schema.
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
    /// Whether anything is held.
    pub(super) fn holds(&self) -> bool {
        self.held.is_some()
    }

    /// Orders what is wanted, or lets go as soon as nothing is.
    pub(super) fn order(&mut self, ui: &Ui, session: &Session, schema: &str, want: Option<Value>) {
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

    pub(super) fn let_go(&mut self, session: &Session) {
        if let Some(held) = self.held.take() {
            session.let_go(&held.schema);
        }
    }
}
