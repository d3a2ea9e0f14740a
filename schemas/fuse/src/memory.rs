//! The state kept across a reload: where the odometry's frame is in that of the export, and the gyro's bias.

use jde_schema::prelude::*;
use jde_schema::types::Start;

use super::Ekf;

impl Memory for Ekf {
    const VERSION: u32 = 1;

    fn save(&self, _: &Context, saving: &mut Saving) {
        let (frame, bias) = self
            .known()
            .map_or((Start::NONE, 0.0), |(frame, bias)| (Start::at(frame), bias));
        saving.put(&frame);
        saving.put(&bias);
    }

    fn restore(&mut self, _: &Context, saved: &mut Saved) -> Result {
        let (frame, bias): (Start, f64) = (saved.take()?, saved.take()?);
        self.kept = frame.get().map(|frame| (frame, bias));
        Ok(())
    }
}
