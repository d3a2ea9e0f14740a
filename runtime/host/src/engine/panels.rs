//! Access to panels, for viewing and touching, and the events of it.

use std::sync::atomic::Ordering;

use jde_core::SchemaId;
use jde_panel::Gesture;
use jde_records::event::{OperatorAction, What};

use super::{Engine, Signal};
use crate::panels::{DrawingCallback, GestureOutcome, PanelError, PanelViewGuard};

impl Engine {
    /// Records whether an instance's build has a panel, and whether the panel can be touched. The contract
    /// accounts for it from now on (R17).
    pub(crate) fn declare_panel(&self, instance: SchemaId, panel: Option<bool>) {
        self.panels.declare(instance, panel);
        self.rules.set_panel(instance, panel.is_some());
    }

    /// Has a panel drawn for as long as the returned [`Look`] lives.
    pub(crate) fn view_panel(
        &self,
        schema: SchemaId,
        rate: f64,
        news: DrawingCallback,
    ) -> Result<PanelViewGuard, PanelError> {
        self.check_panel(schema)?;
        let look = self.panels.add_viewer(schema, rate, news);
        if !self.panels.has_instance(schema) {
            // No runner will report that.
            self.panels.publish_absence(schema, self.clock.now());
        }
        self.rules.signals.send(schema, Signal::PanelOpened);
        Ok(look)
    }

    /// Keeps a gesture until the schema's next turn. A gesture that does not fit the drawn panel is refused.
    /// While the panel is not viewed there is nothing to compare with, and the schema receives the gesture
    /// unchecked.
    pub(crate) fn queue_gesture(
        &self,
        by: &str,
        schema: SchemaId,
        gesture: Gesture,
    ) -> Result<(), PanelError> {
        self.check_panel(schema)?;
        gesture.check().map_err(PanelError::InvalidGesture)?;
        let name = || self.name(schema).to_owned();
        if !self.panels.is_touchable(schema) {
            return Err(PanelError::ReadOnly(name()));
        }
        if let Some(drawn) = self.panels.newest(schema)
            && let Ok(list) = &drawn.list
        {
            list.takes(&gesture).map_err(PanelError::InvalidGesture)?;
        }
        match self.panels.push_gesture(schema, by, gesture) {
            GestureOutcome::Queued => self.rules.signals.send(schema, Signal::GestureQueued),
            GestureOutcome::NoInstance => return Err(PanelError::NoInstance(name())),
            GestureOutcome::Full => return Err(PanelError::QueueFull(name())),
        }
        Ok(())
    }

    /// Reports gestures that were accepted and never delivered, because their schema's instance ended first.
    pub(crate) fn report_undelivered(&self, schema: SchemaId, count: usize) {
        if count == 0 {
            return;
        }
        self.metrics[schema]
            .refused
            .fetch_add(count as u64, Ordering::Relaxed);
        let gestures = if count == 1 { "gesture" } else { "gestures" };
        self.rules.report_now(What::Refused {
            schema,
            description: format!(
                "{count} {gestures} on its panel: it failed or was unloaded before it took them up"
            ),
            retry: None,
        });
    }

    /// The first gesture that waits for a schema. Signals the schema again if there are more.
    pub(crate) fn take_gesture(&self, schema: SchemaId) -> Option<(String, Gesture)> {
        let (first, more) = self.panels.pop_gesture(schema)?;
        if more {
            self.rules.signals.send(schema, Signal::GestureQueued);
        }
        Some(first)
    }

    /// Reports a gesture that is about to be delivered. Returns its number.
    pub(crate) fn report_gesture(&self, by: &str, schema: SchemaId, gesture: &Gesture) -> u64 {
        let number = self.panels.next_delivery_number();
        let action = OperatorAction::Touch {
            schema,
            number,
            gesture: gesture.clone(),
        };
        self.rules.report_operation(by, action);
        number
    }

    fn check_panel(&self, schema: SchemaId) -> Result<(), PanelError> {
        if self.application.instances.get(schema).is_none() {
            let count = self.application.instances.len();
            return Err(PanelError::NoSuchSchema { schema, count });
        }
        if self.clock.is_replayed() {
            return Err(PanelError::InReplay);
        }
        if !self.panels.has_panel(schema) {
            return Err(PanelError::NoPanel(self.name(schema).to_owned()));
        }
        Ok(())
    }
}
