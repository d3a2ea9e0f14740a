//! Who may look at panels and touch them, and what is told of it.

use jde_panel::Gesture;

use super::{Engine, Signal};
use crate::event::OperatorAction;
use crate::panels::{Look, News, Refusal};

impl Engine {
    /// Has a panel be drawn while the answer lives.
    pub(crate) fn look(&self, schema: usize, rate: f64, news: News) -> Result<Look, Refusal> {
        self.has_panel(schema)?;
        let look = self.panels.look(schema, rate, news);
        self.ring(schema, Signal::Looked);
        Ok(look)
    }

    /// Keeps a gesture until the schema's next turn.
    pub(crate) fn touch(&self, by: &str, schema: usize, gesture: Gesture) -> Result<(), Refusal> {
        self.has_panel(schema)?;
        gesture.check().map_err(Refusal::Wrong)?;
        let name = || self.name(schema).to_owned();
        if !self.panels.is_touchable(schema) {
            return Err(Refusal::Untouchable(name()));
        }
        if !self.panels.is_there(schema) {
            return Err(Refusal::Gone(name()));
        }
        if !self.panels.put(schema, by, gesture) {
            return Err(Refusal::Busy(name()));
        }
        self.ring(schema, Signal::Touched);
        Ok(())
    }

    /// A gesture is about to be handed in; answers with its number.
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
