//! The base while the ball is nowhere to be seen from here: it drives on to where there is room. It keeps no map, and where it
//! has been it may go again.

use jde_schema::prelude::*;

use crate::ball::{self, Ball};

/// Drives the base ahead while there is room, and turns on the spot to the side with more room where there is none. Ready while
/// the ball is lost and the head has looked for it in vain.
#[derive(Describe)]
#[schema(motor, period = "33ms", budget = "20ms")]
pub struct Roam {
    /// Where the ball is, in the frame of the base.
    #[import(trigger)]
    ball: Import<Ball>,
    /// What the laser sees ahead.
    #[import]
    laser: Import<LaserScan>,
    /// For how long the head looks for a lost ball alone.
    #[modulation(default = 5.0, unit = "s", min = 0.0)]
    patience: Modulation<f64>,
    /// Half the width of the way it wants free.
    #[modulation(default = 0.4, unit = "m", min = 0.0)]
    half_width: Modulation<f64>,
    /// How much room ahead of the laser makes it turn; more than that before which a brake would stand.
    #[modulation(default = 1.0, unit = "m", min = 0.0)]
    room: Modulation<f64>,
    /// How much more room it wants to drive on.
    #[modulation(default = 0.5, unit = "m", min = 0.0)]
    margin: Modulation<f64>,
    /// How fast it drives.
    #[modulation(default = 0.25, unit = "m/s", min = 0.0)]
    speed: Modulation<f64>,
    /// How fast it turns.
    #[modulation(default = 0.5, unit = "rad/s", min = 0.0)]
    turn_rate: Modulation<f64>,
    /// Speeds of the base.
    #[actuator]
    base: Actuator<Twist>,
    near: Hysteresis,
    /// 1 to turn to the left, -1 to the right; it stays while there is no room, so that a corner does not hold it.
    side: f64,
}

impl Schema for Roam {
    fn check(&mut self, cx: &Context) -> Result<Precondition> {
        let patience = self.patience.get(cx);
        let ball = ball::read(&self.ball, cx);
        let lost = ball.is_some_and(|ball| !ball.is_here() && ball.unseen > patience);
        Ok((lost && self.laser.get(cx).is_some()).into())
    }

    fn iterate(&mut self, cx: &Context) -> Result {
        let Some(laser) = self.laser.get(cx) else {
            return Ok(());
        };
        let ahead = laser.nearest_ahead(self.half_width.get(cx)).unwrap_or(f64::MAX);
        let (had_room, room) = (!self.near.holds(), self.room.get(cx));
        let twist = if self.near.below(ahead, room, room + self.margin.get(cx)) {
            if had_room {
                self.side = wider_side(&laser);
            }
            Twist::planar(0.0, self.side * self.turn_rate.get(cx))
        } else {
            Twist::planar(self.speed.get(cx), 0.0)
        };
        self.base.command(cx, twist);
        Ok(())
    }
}

/// The side with more room: 1 for the left, -1 for the right.
fn wider_side(laser: &LaserScan) -> f64 {
    let sum = |left: bool| -> f64 {
        // What is near narrows a side more than what is far.
        let points = laser.points().filter(|point| (point.y > 0.0) == left);
        points.map(|point| 1.0 / point.range.max(0.05)).sum()
    };
    if sum(true) <= sum(false) { 1.0 } else { -1.0 }
}
