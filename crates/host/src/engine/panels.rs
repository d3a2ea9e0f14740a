//! Access to panels, for viewing and touching, and the events of it.

use std::sync::atomic::Ordering;

use jde_core::GroupId;
use jde_panel::Gesture;

use super::{Engine, Signal};
use crate::event::{Event, OperatorAction};
use crate::panels::{Look, News, Put, Refusal};

impl Engine {
    /// Records whether an instance's build has a panel, and whether the panel can be touched. The contract
    /// accounts for it from now on (R17).
    pub(crate) fn declare_panel(&self, instance: usize, panel: Option<bool>) {
        self.panels.declare(instance, panel);
        let changed = self
            .lock()
            .hierarchy
            .set_panel(super::schema(instance), panel.is_some());
        if changed && let Some(group) = self.application.instances[instance].group {
            self.renew_contract(GroupId(group as u32));
        }
    }

    /// Has a panel drawn for as long as the returned [`Look`] lives.
    pub(crate) fn look(&self, schema: usize, rate: f64, news: News) -> Result<Look, Refusal> {
        self.has_panel(schema)?;
        let look = self.panels.look(schema, rate, news);
        if !self.panels.is_there(schema) {
            // No runner will report that.
            self.panels.show_gone(schema, self.clock.now());
        }
        self.ring(schema, Signal::Looked);
        Ok(look)
    }

    /// Keeps a gesture until the schema's next turn. A gesture that does not fit the drawn panel is refused.
    /// While the panel is not viewed there is nothing to compare with, and the schema receives the gesture
    /// unchecked.
    pub(crate) fn touch(&self, by: &str, schema: usize, gesture: Gesture) -> Result<(), Refusal> {
        self.has_panel(schema)?;
        gesture.check().map_err(Refusal::Wrong)?;
        let name = || self.name(schema).to_owned();
        if !self.panels.is_touchable(schema) {
            return Err(Refusal::Untouchable(name()));
        }
        if let Some(drawn) = self.panels.newest(schema)
            && let Ok(list) = &drawn.list
        {
            list.takes(&gesture).map_err(Refusal::Wrong)?;
        }
        match self.panels.put(schema, by, gesture) {
            Put::Kept => self.ring(schema, Signal::Touched),
            Put::Gone => return Err(Refusal::Gone(name())),
            Put::Full => return Err(Refusal::Busy(name())),
        }
        Ok(())
    }

    /// Reports gestures that were accepted and never delivered, because their schema's instance ended first.
    pub(crate) fn untouched(&self, schema: usize, count: usize) {
        if count == 0 {
            return;
        }
        self.meters[schema]
            .refused
            .fetch_add(count as u64, Ordering::Relaxed);
        let gestures = if count == 1 { "gesture" } else { "gestures" };
        self.report(&Event::Refused {
            time: self.clock.now(),
            schema,
            what: format!(
                "{count} {gestures} on its panel: it failed or was unloaded before it took them up"
            ),
        });
    }

    /// The first gesture that waits for a schema. Signals the schema again if there are more.
    pub(crate) fn take_gesture(&self, schema: usize) -> Option<(String, Gesture)> {
        let (first, more) = self.panels.take(schema)?;
        if more {
            self.ring(schema, Signal::Touched);
        }
        Some(first)
    }

    /// Reports a gesture that is about to be delivered. Returns its number.
    pub(crate) fn touched(&self, by: &str, schema: usize, gesture: &Gesture) -> u64 {
        let number = self.panels.next_handed();
        let action = OperatorAction::Touch {
            schema,
            number,
            gesture: gesture.clone(),
        };
        self.operated(by, action);
        number
    }

    fn has_panel(&self, schema: usize) -> Result<(), Refusal> {
        let count = self.application.instances.len();
        if schema >= count {
            return Err(Refusal::Nobody(schema, count));
        }
        if self.clock.is_past() {
            return Err(Refusal::Past);
        }
        if !self.panels.has(schema) {
            return Err(Refusal::NoPanel(self.name(schema).to_owned()));
        }
        Ok(())
    }
}
