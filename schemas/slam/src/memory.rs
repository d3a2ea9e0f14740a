//! The state kept across a reload: where the robot is. The map of the new build is that of the file, or begins anew there.

use jde_schema::prelude::*;
use jde_schema::types::Start;

use super::Slam;

impl Memory for Slam {
    fn save(&self, _: &Context, saving: &mut Saving) {
        saving.put(&self.place().map_or(Start::NONE, Start::at));
    }

    fn restore(&mut self, cx: &Context, saved: &mut Saved) -> Result {
        self.restored = saved.take::<Start>()?.get();
        match self.restored {
            // A build that goes on as the new one failed has its map.
            Some(place) if self.slam.scans().is_empty() => self.resume(cx, place),
            _ => Ok(()),
        }
    }
}

impl Slam {
    /// Returns where the robot was last, if that is known.
    pub(crate) fn place(&self) -> Option<Pose2D> {
        let is_begun = self.is_loading() || !self.slam.scans().is_empty();
        let last = self.last.filter(|_| is_begun);
        last.map(|last| self.slam.pose(&last)).or(self.restored)
    }
}
