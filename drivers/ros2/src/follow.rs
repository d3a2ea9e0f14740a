//! The motor schema by which a ROS 2 program drives a robot of ours. It competes like any other (R13), so that a brake or a
//! person goes before it if the application says so.

use jde_schema::prelude::*;

/// Drives the base as a velocity that came from elsewhere says, while it is fresh.
#[derive(Describe)]
#[schema(motor, period = "50ms", budget = "10ms")]
pub struct Follow {
    /// The velocity.
    #[import(trigger)]
    cmd_vel: Import<Twist>,
    /// How old the velocity may be; longer than the time between two.
    #[modulation(default = 0.5, unit = "s", min = 0.01)]
    patience: Modulation<f64>,
    /// Speeds of the base.
    #[actuator]
    base: Actuator<Twist>,
}

impl Schema for Follow {
    fn check(&mut self, cx: &Context) -> Result<Precondition> {
        Ok(self.fresh(cx).is_some().into())
    }

    fn iterate(&mut self, cx: &Context) -> Result {
        if let Some(twist) = self.fresh(cx) {
            self.base.command(cx, twist);
        }
        Ok(())
    }
}

impl Follow {
    fn fresh(&self, cx: &Context) -> Option<Twist> {
        let sample = self.cmd_vel.get(cx)?;
        (sample.age(cx).as_secs_f64() <= self.patience.get(cx)).then_some(*sample)
    }
}
