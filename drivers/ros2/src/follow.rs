//! The motor schema through which a ROS 2 program drives a robot. It competes like any other (R13), so the
//! application can give a brake or a person precedence.

use jde_schema::prelude::*;

/// Drives the base with a velocity from another program while it is fresh.
#[derive(Describe)]
#[schema(motor, period = "50ms", budget = "10ms")]
pub struct Follow {
    /// The velocity.
    #[import(trigger)]
    cmd_vel: Import<Twist>,
    /// Oldest velocity that counts; longer than the time between two velocities.
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
