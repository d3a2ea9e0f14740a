//! The head while the ball is here: it is kept in the middle of the picture. It moves no base.

use jde_schema::prelude::*;

use crate::ball::{self, Ball};

/// Turns the head so that the camera looks at the ball. Ready while the ball is here.
#[derive(Describe)]
#[schema(motor, period = "33ms", budget = "20ms")]
pub struct Track {
    /// Where the ball is, in the frame of the base.
    #[import(trigger)]
    ball: Import<Ball>,
    /// Where the head looks.
    #[import]
    pan_tilt: Import<PanTilt>,
    /// Speed of the head for each rad that it looks beside the ball. Times the age of the pictures, s, it stays below 1.
    #[modulation(default = 4.0, unit = "1/s", min = 0.0)]
    gain: Modulation<f64>,
    /// The fastest it turns.
    #[modulation(default = 1.5, unit = "rad/s", min = 0.0)]
    fastest: Modulation<f64>,
    /// How far beside the ball it may look without turning, so that noise does not wear out the gears.
    #[modulation(default = 0.5_f64.to_radians(), unit = "rad", min = 0.0)]
    tolerance: Modulation<f64>,
    /// The pan-tilt head.
    #[actuator]
    head: Actuator<PanTilt>,
}

impl Schema for Track {
    fn check(&mut self, cx: &Context) -> Result<Precondition> {
        let here = ball::read(&self.ball, cx).is_some_and(|ball| ball.is_here());
        Ok((here && self.pan_tilt.get(cx).is_some()).into())
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
    /// How fast to turn an axis that looks so far beside the ball, rad/s; 0 holds it.
    fn speed(&self, cx: &Context, error: f64) -> f64 {
        if error.abs() <= self.tolerance.get(cx) {
            return 0.0;
        }
        (self.gain.get(cx) * error.abs()).min(self.fastest.get(cx))
    }
}
