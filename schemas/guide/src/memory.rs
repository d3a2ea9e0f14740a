//! The state kept across a reload: how often each task was done, and what is due.

use jde_schema::prelude::*;

use super::Guide;
use crate::charge::Charge;

impl Memory for Guide {
    const VERSION: u32 = 2;

    fn save(&self, _: &Context, saving: &mut Saving) {
        for task in [&self.docking, &self.leading, &self.following, &self.mapping] {
            saving.put(&task.done());
            saving.put_text(task.reason().unwrap_or_default());
        }
        saving.put(&(self.charge.passed() as u64));
        saving.put(&self.led_to.unwrap_or_default());
        saving.put_all(self.asked.as_slice());
    }

    fn restore(&mut self, cx: &Context, saved: &mut Saved) -> Result {
        for task in [
            &mut self.docking,
            &mut self.leading,
            &mut self.following,
            &mut self.mapping,
        ] {
            task.set_done(saved.take()?);
            let reason = saved.take_text()?;
            if !reason.is_empty() {
                task.resume(cx, reason);
            }
        }
        self.charge = Charge::resume(cx.now(), saved.take::<u64>()? as usize);
        self.led_to = Some(saved.take()?);
        self.asked = saved.take_all()?.first().copied();
        // Who waves now has waved before.
        self.wave.take(cx.now());
        Ok(())
    }
}
