//! Drives straight to the target while the path is free (the paper, section 5). It avoids no obstacles.

mod panel;

use jde_schema::prelude::*;
use jde_schema::types::Ahead;

/// Drives the base toward the target at high speed while the area ahead is free.
///
/// The heading error selects one of three bands: straight and fast, slowly while turning, or a turn on the
/// spot. The bands and speeds are those of 2007.
#[derive(Describe)]
#[schema(motor, period = "75ms", budget = "20ms")]
pub struct Goon {
    /// The scan of the laser.
    #[import(trigger)]
    laser: Import<LaserScan>,
    /// The estimated pose of the robot.
    #[import]
    pose: Import<Odometry>,
    /// The target.
    #[modulation(default = Target::NONE)]
    target: Modulation<Target>,
    /// Half the width of the area that must be free.
    #[modulation(default = 1.0, unit = "m", min = 0.0, max = 5.0)]
    half_width: Modulation<f64>,
    /// How far ahead of the laser that area reaches.
    #[modulation(default = 3.0, unit = "m", min = 0.0)]
    ahead: Modulation<f64>,
    /// Speed when the target is straight ahead.
    #[modulation(default = 0.4, unit = "m/s", min = 0.0)]
    fast: Modulation<f64>,
    /// Speed while turning toward the target.
    #[modulation(default = 0.2, unit = "m/s", min = 0.0)]
    slow: Modulation<f64>,
    /// Turn rate, on the move and on the spot.
    #[modulation(default = 50_f64.to_radians(), unit = "rad/s", min = 0.0)]
    turn: Modulation<f64>,
    /// Heading error below which it goes straight.
    #[modulation(default = 10_f64.to_radians(), unit = "rad", min = 0.0, max = 3.15)]
    straight: Modulation<f64>,
    /// Heading error below which it turns on the move.
    #[modulation(default = 40_f64.to_radians(), unit = "rad", min = 0.0, max = 3.15)]
    veer: Modulation<f64>,
    /// Speeds of the base.
    #[actuator]
    base: Actuator<Twist>,
}

/// The reaction to a heading error.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Band {
    /// Drives straight and fast.
    Straight,
    /// Turns on the move.
    Veer,
    /// Turns on the spot.
    Turn,
}

impl Schema for Goon {
    fn check(&mut self, cx: &Context) -> Result<Precondition> {
        Ok((self.local_target(cx).is_some() && self.is_free(cx)).into())
    }

    fn iterate(&mut self, cx: &Context) -> Result {
        let pose = self.pose.require(cx)?;
        let Some(target) = self.target.get(cx).get() else {
            self.base.command(cx, Twist::ZERO);
            return Ok(());
        };
        let error = pose.pose2d().bearing_to(&target);
        let turn = self.turn.get(cx).copysign(error);
        let twist = match self.band(cx, error) {
            Band::Straight => Twist::planar(self.fast.get(cx), 0.0),
            Band::Veer => Twist::planar(self.slow.get(cx), turn),
            Band::Turn => Twist::planar(0.0, turn),
        };
        self.base.command(cx, twist);
        Ok(())
    }
}

impl Goon {
    /// Whether the laser sees the area ahead, and no obstacle in it.
    fn is_free(&self, cx: &Context) -> bool {
        let (side, ahead) = (self.half_width.get(cx), self.ahead.get(cx));
        let laser = self.laser.get(cx);
        laser.is_some_and(|laser| laser.ahead(side, ahead) == Ahead::Free)
    }

    /// The target in the robot's frame.
    fn local_target(&self, cx: &Context) -> Option<Pose2D> {
        let target = self.target.get(cx).get()?;
        Some(self.pose.get(cx)?.pose2d().localize(&target))
    }

    fn band(&self, cx: &Context, error: f64) -> Band {
        if error.abs() < self.straight.get(cx) {
            Band::Straight
        } else if error.abs() < self.veer.get(cx) {
            Band::Veer
        } else {
            Band::Turn
        }
    }
}

jde_schema::export!(
    "goon",
    "Drives straight to a target while the path is free.",
    [Goon]
);

#[cfg(test)]
mod tests;
