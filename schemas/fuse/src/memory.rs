//! The state kept across a reload: where the odometry's frame is in that of the export, how well that is known, and the gyro's
//! bias.

use jde_schema::prelude::*;
use jde_schema::types::Start;

use super::Ekf;
use super::begin::Kept;

impl Memory for Ekf {
    const VERSION: u32 = 2;

    fn save(&self, _: &Context, saving: &mut Saving) {
        let kept = self.known();
        saving.put(&u8::from(self.has_begun));
        saving.put(&self.known_bias().unwrap_or(f64::NAN));
        saving.put(&kept.map_or(Start::NONE, |kept| Start::at(kept.frame)));
        saving.put(&kept.map_or(Start::NONE, |kept| Start::at(kept.rolled)));
        let [a, b, c] = kept.map_or([[0.0; 3]; 3], |kept| kept.covariance);
        saving.put(&a);
        saving.put(&b);
        saving.put(&c);
    }

    fn restore(&mut self, _: &Context, saved: &mut Saved) -> Result {
        self.has_begun = saved.take::<u8>()? != 0;
        let bias: f64 = saved.take()?;
        self.bias = Some(bias).filter(|bias| bias.is_finite());
        let (frame, rolled): (Start, Start) = (saved.take()?, saved.take()?);
        let covariance = [saved.take()?, saved.take()?, saved.take()?];
        self.kept = frame.get().zip(rolled.get()).map(|(frame, rolled)| Kept {
            frame,
            covariance,
            rolled,
        });
        Ok(())
    }
}
