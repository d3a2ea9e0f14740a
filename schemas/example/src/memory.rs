//! The state kept across a reload: the progress of the mission, and the target set on the panel.

use jde_schema::prelude::*;

use super::{Example, TargetRequest};

impl Memory for Example {
    fn save(&self, _: &Context, saving: &mut Saving) {
        saving.put(&self.reached);
        let positions: Vec<_> = self.request.iter().map(|request| request.position).collect();
        saving.put_all(&positions);
        saving.put_text(self.request.as_ref().map_or("", |request| &request.operator));
        saving.put(&self.skipped);
    }

    fn restore(&mut self, _: &Context, saved: &mut Saved) -> Result {
        self.reached = saved.take()?;
        let position = saved.take_all()?.into_iter().next();
        let operator = saved.take_text()?.to_owned();
        self.request = position.map(|position| TargetRequest { position, operator });
        // Earlier builds did not save this number.
        self.skipped = saved.take().unwrap_or_default();
        Ok(())
    }
}
