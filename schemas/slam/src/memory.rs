//! The state kept across a reload: where the robot is. The map of the new build is that of the file, or begins anew there.

use jde_schema::prelude::*;
use jde_schema::types::Start;

use super::Slam;

impl Memory for Slam {
    fn save(&self, _: &Context, saving: &mut Saving) {
        let anchor = self.last.and_then(|last| self.slam.anchor(&last));
        let place = anchor.map(|anchor| self.slam.place(&anchor)).or(self.restored);
        saving.put(&place.map_or(Start::NONE, Start::at));
    }

    fn restore(&mut self, cx: &Context, saved: &mut Saved) -> Result {
        self.restored = saved.take::<Start>()?.get();
        match self.restored {
            Some(place) => self.begin(cx, place),
            None => Ok(()),
        }
    }
}
