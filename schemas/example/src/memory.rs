//! The state kept across a reload: the progress through the targets.

use jde_schema::prelude::*;

use super::Example;

impl Memory for Example {
    fn save(&self, _: &Context, saving: &mut Saving) {
        self.targets.save(saving);
    }

    fn restore(&mut self, _: &Context, saved: &mut Saved) -> Result {
        self.targets.restore(saved)
    }
}
