//! The state kept across a reload: what an operator has drawn.

use jde_schema::prelude::*;

use super::Plan;

impl Memory for Plan {
    fn save(&self, _: &Context, saving: &mut Saving) {
        saving.put(&self.drawn.zones);
        saving.put(&self.drawn.lanes);
        saving.put(&self.drawn.points);
        saving.put(&self.drawn.width);
    }

    fn restore(&mut self, _: &Context, saved: &mut Saved) -> Result {
        self.drawn.zones = saved.take()?;
        self.drawn.lanes = saved.take()?;
        self.drawn.points = saved.take()?;
        self.drawn.width = saved.take()?;
        Ok(())
    }
}
