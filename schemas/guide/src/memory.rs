//! The state kept across a reload: how often each task was done. What was due begins anew.

use jde_schema::prelude::*;

use super::Guide;

impl Memory for Guide {
    fn save(&self, _: &Context, saving: &mut Saving) {
        for task in [&self.docking, &self.leading, &self.following, &self.mapping] {
            saving.put(&task.done());
        }
        saving.put(&self.asked);
    }

    fn restore(&mut self, _: &Context, saved: &mut Saved) -> Result {
        for task in [
            &mut self.docking,
            &mut self.leading,
            &mut self.following,
            &mut self.mapping,
        ] {
            task.set_done(saved.take()?);
        }
        self.asked = saved.take()?;
        Ok(())
    }
}
