//! The state kept across a reload: the progress of the mission, and the target set on the panel.

use jde_schema::prelude::*;

use super::{Example, TargetRequest};

impl Memory for Example {
    fn save(&self, _: &Context, saving: &mut Saving) {
        saving.put(&self.reached);
        let places: Vec<_> = self
            .requested_target
            .iter()
            .map(|request| request.position)
            .collect();
        saving.put_all(&places);
        saving.put_text(self.requested_target.as_ref().map_or("", |request| &request.by));
        saving.put(&self.skipped);
    }

    fn restore(&mut self, _: &Context, saved: &mut Saved) -> Result {
        self.reached = saved.take()?;
        let at = saved.take_all()?.into_iter().next();
        let by = saved.take_text()?.to_owned();
        self.requested_target = at.map(|at| TargetRequest { position: at, by });
        // Earlier builds did not save this number.
        self.skipped = saved.take().unwrap_or_default();
        Ok(())
    }
}
