//! Turns the head while the ball is lost. It does not move the base.

use jde_schema::prelude::*;

use crate::ball::{self, Ball};

/// Sweeps the head from side to side, starting with the side on which the ball was last seen. Ready while the
/// ball is lost.
#[derive(Describe)]
#[schema(motor, period = "33ms", budget = "20ms")]
pub struct Search {
    /// Where the ball is, in the frame of the base.
    #[import(trigger)]
    ball: Import<Ball>,
    /// The measured position of the head.
    #[import]
    pan_tilt: Import<PanTilt>,
    /// Pan angle of the sweep to either side.
    #[modulation(default = 70_f64.to_radians(), unit = "rad", min = 0.0, max = 3.15)]
    sweep: Modulation<f64>,
    /// Tilt during the sweep, positive downward.
    #[modulation(default = 7_f64.to_radians(), unit = "rad")]
    tilt: Modulation<f64>,
    /// Turn rate.
    #[modulation(default = 0.8, unit = "rad/s", min = 0.01)]
    speed: Modulation<f64>,
    /// The pan-tilt head.
    #[actuator]
    head: Actuator<PanTilt>,
    turn: Option<HeadTurn>,
}

/// One turn of the head to one side.
#[derive(Clone, Copy)]
struct HeadTurn {
    /// 1 to the left, -1 to the right.
    side: f64,
    since: Duration,
}

impl Schema for Search {
    fn check(&mut self, cx: &Context) -> Result<Precondition> {
        let lost = ball::read(&self.ball, cx).is_some_and(|ball| !ball.is_known());
        let ready = lost && self.pan_tilt.get(cx).is_some();
        if !ready {
            self.turn = None;
        }
        Ok(ready.into())
    }

    fn iterate(&mut self, cx: &Context) -> Result {
        let (Some(ball), Some(now)) = (ball::read(&self.ball, cx), self.pan_tilt.get(cx)) else {
            return Ok(());
        };
        let (sweep, speed) = (self.sweep.get(cx), self.speed.get(cx));
        let mut turn = self.turn.unwrap_or(HeadTurn {
            side: 1_f64.copysign(ball.bearing),
            since: cx.now(),
        });
        // The head also turns back after this time, in case it cannot reach the angle or turns more slowly
        // than commanded.
        let limit = 2.0 * sweep / speed + 1.0;
        let expired = (cx.now().saturating_sub(turn.since)).as_secs_f64() > limit;
        if expired || turn.side * now.pan >= sweep - 1_f64.to_radians() {
            turn = HeadTurn {
                side: -turn.side,
                since: cx.now(),
            };
        }
        self.turn = Some(turn);
        self.head.command(
            cx,
            PanTilt {
                header: Header::new(cx.now(), "base_link"),
                pan: turn.side * sweep,
                tilt: self.tilt.get(cx),
                pan_velocity: speed,
                tilt_velocity: speed,
            },
        );
        Ok(())
    }
}
