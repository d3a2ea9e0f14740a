//! Turns the head while the ball is seen, so that the ball stays in the middle of the picture. It does not
//! move the base.

use jde_schema::prelude::*;

use crate::ball::{self, Ball};

/// Turns the head so that the camera points at the ball. Ready while the position of the ball is known.
#[derive(Describe)]
#[schema(motor, period = "33ms", budget = "20ms")]
pub struct Track {
    /// Where the ball is, in the frame of the base.
    #[import(trigger)]
    ball: Import<Ball>,
    /// The measured position of the head.
    #[import]
    pan_tilt: Import<PanTilt>,
    /// Turn rate of the head per rad of error. Its product with the age of the pictures, s, must stay below
    /// 1.
    #[modulation(default = 4.0, unit = "1/s", min = 0.0)]
    gain: Modulation<f64>,
    /// Highest turn rate.
    #[modulation(default = 1.5, unit = "rad/s", min = 0.0)]
    fastest: Modulation<f64>,
    /// Error within which the head does not turn, so that noise does not wear out its gears.
    #[modulation(default = 0.5_f64.to_radians(), unit = "rad", min = 0.0)]
    tolerance: Modulation<f64>,
    /// The pan-tilt head.
    #[actuator]
    head: Actuator<PanTilt>,
}

impl Schema for Track {
    fn check(&mut self, cx: &Context) -> Result<Precondition> {
        let known = ball::read(&self.ball, cx).is_some_and(|ball| ball.is_known());
        Ok((known && self.pan_tilt.get(cx).is_some()).into())
    }

    fn iterate(&mut self, cx: &Context) -> Result {
        let (Some(ball), Some(now)) = (ball::read(&self.ball, cx), self.pan_tilt.get(cx)) else {
            return Ok(());
        };
        let (pan, tilt) = (ball.bearing, -ball.elevation);
        self.head.command(
            cx,
            PanTilt {
                header: Header::new(cx.now(), "base_link"),
                pan,
                tilt,
                pan_velocity: self.speed(cx, pan - now.pan),
                tilt_velocity: self.speed(cx, tilt - now.tilt),
            },
        );
        Ok(())
    }
}

impl Track {
    /// Returns the turn rate of an axis with this error, rad/s; 0 holds the axis.
    fn speed(&self, cx: &Context, error: f64) -> f64 {
        if error.abs() <= self.tolerance.get(cx) {
            return 0.0;
        }
        (self.gain.get(cx) * error.abs()).min(self.fastest.get(cx))
    }
}
