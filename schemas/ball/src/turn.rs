//! Turns the base on the spot: toward a ball that is far to the side, or once around if the head alone does
//! not find it. The base does not leave its position, so that a round robot cannot collide.

use core::f64::consts::TAU;

use jde_schema::prelude::*;

use crate::ball::{self, Ball};

/// Turns the base on the spot toward a ball that is far to the side, and once around when the head has not
/// found a lost ball.
#[derive(Describe)]
#[schema(motor, period = "33ms", budget = "20ms")]
pub struct Turn {
    /// Where the ball is, in the frame of the base.
    #[import(trigger)]
    ball: Import<Ball>,
    /// Bearing of the ball, to either side, at which it starts.
    #[modulation(default = 35_f64.to_radians(), unit = "rad", min = 0.0, max = 3.15)]
    enter: Modulation<f64>,
    /// Bearing of the ball, to either side, at which it ends.
    #[modulation(default = 10_f64.to_radians(), unit = "rad", min = 0.0, max = 3.15)]
    leave: Modulation<f64>,
    /// Time for which only the head searches for a lost ball.
    #[modulation(default = 5.0, unit = "s", min = 0.0)]
    patience: Modulation<f64>,
    /// Turn rate toward the ball.
    #[modulation(default = 0.6, unit = "rad/s", min = 0.0)]
    rate: Modulation<f64>,
    /// Turn rate while the ball is lost.
    #[modulation(default = 0.5, unit = "rad/s", min = 0.01)]
    search_rate: Modulation<f64>,
    /// Speeds of the base.
    #[actuator]
    base: Actuator<Twist>,
    to_the_side: Hysteresis,
}

impl Schema for Turn {
    fn check(&mut self, cx: &Context) -> Result<Precondition> {
        let Some(ball) = ball::read(&self.ball, cx) else {
            self.to_the_side.reset();
            return Ok(false.into());
        };
        let ready = if ball.is_known() {
            let (enter, leave) = (self.enter.get(cx), self.leave.get(cx));
            self.to_the_side.above(ball.bearing.abs(), enter, leave)
        } else {
            self.to_the_side.reset();
            let turning = ball.unseen - self.patience.get(cx);
            turning > 0.0 && turning < TAU / self.search_rate.get(cx)
        };
        Ok(ready.into())
    }

    fn iterate(&mut self, cx: &Context) -> Result {
        let Some(ball) = ball::read(&self.ball, cx) else {
            return Ok(());
        };
        let rate = if ball.is_known() {
            &self.rate
        } else {
            &self.search_rate
        };
        self.base
            .command(cx, Twist::planar(0.0, rate.get(cx).copysign(ball.bearing)));
        Ok(())
    }
}
