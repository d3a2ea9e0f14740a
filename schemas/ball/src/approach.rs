//! Drives the base to the ball. It avoids no obstacles: another schema must brake.

use jde_schema::prelude::*;

use crate::ball::{self, Ball};

/// Drives the base toward the ball, more slowly as it gets nearer, and stops at a distance. Ready while the
/// position of the ball is known and farther away than that.
#[derive(Describe)]
#[schema(motor, period = "33ms", budget = "20ms")]
pub struct Approach {
    /// Where the ball is, in the frame of the base.
    #[import(trigger)]
    ball: Import<Ball>,
    /// Distance at which it stops, along the floor from the camera to the middle of the ball.
    #[modulation(default = 0.8, unit = "m", min = 0.0)]
    distance: Modulation<f64>,
    /// Additional distance at which it starts again.
    #[modulation(default = 0.1, unit = "m", min = 0.0)]
    margin: Modulation<f64>,
    /// Highest speed.
    #[modulation(default = 0.35, unit = "m/s", min = 0.0)]
    speed: Modulation<f64>,
    /// Speed per metre of remaining distance.
    #[modulation(default = 0.5, unit = "1/s", min = 0.0)]
    gain: Modulation<f64>,
    /// Lowest speed.
    #[modulation(default = 0.06, unit = "m/s", min = 0.0)]
    slowest: Modulation<f64>,
    /// Turn rate per rad of bearing.
    #[modulation(default = 1.0, unit = "1/s", min = 0.0)]
    turn: Modulation<f64>,
    /// Highest turn rate.
    #[modulation(default = 0.6, unit = "rad/s", min = 0.0)]
    turn_rate: Modulation<f64>,
    /// Speeds of the base.
    #[actuator]
    base: Actuator<Twist>,
    far: Hysteresis,
}

impl Schema for Approach {
    fn check(&mut self, cx: &Context) -> Result<Precondition> {
        let Some(ball) = ball::read(&self.ball, cx).filter(Ball::is_known) else {
            self.far.reset();
            return Ok(false.into());
        };
        let leave = self.distance.get(cx);
        let far = self.far.above(ball.ahead(), leave + self.margin.get(cx), leave);
        Ok(far.into())
    }

    fn iterate(&mut self, cx: &Context) -> Result {
        let Some(ball) = ball::read(&self.ball, cx) else {
            return Ok(());
        };
        let remaining = ball.ahead() - self.distance.get(cx);
        let target_speed = (self.gain.get(cx) * remaining).max(self.slowest.get(cx));
        let speed = target_speed.min(self.speed.get(cx)) * libm::cos(ball.bearing).max(0.0);
        let fastest = self.turn_rate.get(cx);
        let turn = (self.turn.get(cx) * ball.bearing).clamp(-fastest, fastest);
        self.base.command(cx, Twist::planar(speed, turn));
        Ok(())
    }
}
