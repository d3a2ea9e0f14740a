//! The state kept across a reload: where the robot is.

use jde_schema::prelude::*;
use jde_schema::types::Start;

use super::Mcl;

impl Memory for Mcl {
    fn save(&self, _: &Context, saving: &mut Saving) {
        let place = self.localizer.as_ref().zip(self.last);
        let place = place.and_then(|(localizer, last)| localizer.pose(&last));
        // A reload just after another one has nothing new.
        saving.put(&place.or(self.restored).map_or(Start::NONE, Start::at));
    }

    fn restore(&mut self, _: &Context, saved: &mut Saved) -> Result {
        self.restored = saved.take::<Start>()?.get();
        Ok(())
    }
}
