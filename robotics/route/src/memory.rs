//! The state kept across a reload: the progress of the mission, and the target set on the panel.

use jde_schema::prelude::*;

use super::{TargetRequest, Targets};

impl Targets {
    /// Saves the progress and the target of an operator.
    pub fn save(&self, saving: &mut Saving) {
        saving.put(&self.reached);
        let positions: Vec<_> = self.request.iter().map(|request| request.position).collect();
        saving.put_all(&positions);
        saving.put_text(self.request.as_ref().map_or("", |request| &request.operator));
        saving.put(&self.skipped);
        saving.put(&self.chosen_reached);
    }

    /// Restores what [`Self::save`] saved.
    ///
    /// # Errors
    /// Something else was saved.
    pub fn restore(&mut self, saved: &mut Saved) -> Result {
        self.reached = saved.take()?;
        let position = saved.take_all()?.into_iter().next();
        let operator = saved.take_text()?.to_owned();
        self.request = position.map(|position| TargetRequest { position, operator });
        // Earlier builds did not save these numbers.
        self.skipped = saved.take().unwrap_or_default();
        self.chosen_reached = saved.take().unwrap_or_default();
        Ok(())
    }
}
