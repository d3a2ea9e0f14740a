//! The state kept across a reload: where the robot is, if that is known.

use jde_schema::prelude::*;
use jde_schema::types::Start;

use super::Mcl;

impl Memory for Mcl {
    const VERSION: u32 = 2;

    fn save(&self, _: &Context, saving: &mut Saving) {
        // A reload just after another one has nothing new.
        saving.put_all::<Start>(self.kept(self.last).as_slice());
    }

    fn restore(&mut self, _: &Context, saved: &mut Saved) -> Result {
        self.restored = saved.take_all::<Start>()?.first().copied();
        Ok(())
    }
}
