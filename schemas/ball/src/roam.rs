//! Drives the base while the ball is not visible from the present place: it drives where there is room. It
//! has no map, and may return to places where it has been.

use jde_schema::prelude::*;
use jde_schema::types::Ahead;

use crate::ball::{self, Ball};

/// Drives the base ahead while there is room; otherwise turns it on the spot to the side with more room.
/// Ready while the ball is lost and the head alone has not found it.
#[derive(Describe)]
#[schema(motor, period = "33ms", budget = "20ms")]
pub struct Roam {
    /// Where the ball is, in the frame of the base.
    #[import(trigger)]
    ball: Import<Ball>,
    /// The scan of the laser.
    #[import]
    laser: Import<LaserScan>,
    /// Time for which only the head searches for a lost ball.
    #[modulation(default = 5.0, unit = "s", min = 0.0)]
    patience: Modulation<f64>,
    /// Half the width of the path that must be free.
    #[modulation(default = 0.4, unit = "m", min = 0.0, max = 5.0)]
    half_width: Modulation<f64>,
    /// Room ahead of the laser at which it starts to turn. Greater than the room at which a brake stops the
    /// base.
    #[modulation(default = 1.0, unit = "m", min = 0.0)]
    room: Modulation<f64>,
    /// Additional room that it needs to drive on.
    #[modulation(default = 0.5, unit = "m", min = 0.0)]
    margin: Modulation<f64>,
    /// Forward speed.
    #[modulation(default = 0.25, unit = "m/s", min = 0.0)]
    speed: Modulation<f64>,
    /// Turn rate.
    #[modulation(default = 0.5, unit = "rad/s", min = 0.0)]
    turn_rate: Modulation<f64>,
    /// Speeds of the base.
    #[actuator]
    base: Actuator<Twist>,
    near: Hysteresis,
    /// 1 to turn to the left, -1 to the right. It is kept while there is no room, so that a corner cannot
    /// trap the robot.
    side: f64,
}

impl Schema for Roam {
    fn check(&mut self, cx: &Context) -> Result<Precondition> {
        let patience = self.patience.get(cx);
        let ball = ball::read(&self.ball, cx);
        let lost = ball.is_some_and(|ball| !ball.is_known() && ball.unseen > patience);
        Ok((lost && self.laser.get(cx).is_some()).into())
    }

    fn iterate(&mut self, cx: &Context) -> Result {
        let Some(laser) = self.laser.get(cx) else {
            self.base.command(cx, Twist::ZERO);
            return Ok(());
        };
        let (had_room, room) = (!self.near.holds(), self.room.get(cx));
        let most = room + self.margin.get(cx);
        let ahead = match laser.ahead(self.half_width.get(cx), most) {
            Ahead::Hit(nearest) => nearest,
            Ahead::Free => f64::MAX,
            // It turns on the spot, as before an obstacle.
            Ahead::Unseen => 0.0,
        };
        let twist = if self.near.below(ahead, room, most) {
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

/// Returns the side with more room: 1 for the left, -1 for the right.
fn wider_side(laser: &LaserScan) -> f64 {
    let sum = |left: bool| -> f64 {
        // Near points narrow a side more than far ones.
        let points = laser.points().filter(|point| (point.y > 0.0) == left);
        points.map(|point| 1.0 / point.range.max(0.05)).sum()
    };
    if sum(true) <= sum(false) { 1.0 } else { -1.0 }
}
