//! Drives around a close obstacle toward the target by a virtual force field (the paper, section 5;
//! Borenstein and Koren, "Real-time obstacle avoidance for fast mobile robots", 1989). It has no map and can
//! get stuck in a corner.

mod force;
mod panel;

use jde_schema::prelude::*;

use force::{FieldWeights, Forces};

/// Drives the base around an obstacle in the area ahead while approaching the target.
///
/// The target attracts, every laser return repels, and the base follows the sum with the bands and speeds of
/// 2007. The urgency is the absolute heading error, rad, so that a father can tell whether the schema would
/// turn on the spot.
#[derive(Describe)]
#[schema(motor, period = "75ms", budget = "20ms")]
pub struct Vff {
    /// The scan of the laser.
    #[import(trigger)]
    laser: Import<LaserScan>,
    /// The estimated pose of the robot.
    #[import]
    pose: Import<Odometry>,
    /// The target.
    #[modulation(default = Target::NONE)]
    target: Modulation<Target>,
    /// Half the width of the area in which an obstacle makes it ready.
    #[modulation(default = 1.0, unit = "m", min = 0.0, max = 5.0)]
    half_width: Modulation<f64>,
    /// How far ahead of the laser that area reaches.
    #[modulation(default = 3.0, unit = "m", min = 0.0)]
    ahead: Modulation<f64>,
    /// How much larger the area is while an obstacle is in it. A value above 0 prevents chattering at the
    /// area's edge; the father must then prefer this schema to one that requires a free path.
    #[modulation(default = 0.0, unit = "m", min = 0.0)]
    margin: Modulation<f64>,
    /// Speed when the force points straight ahead.
    #[modulation(default = 0.2, unit = "m/s", min = 0.0)]
    fast: Modulation<f64>,
    /// Speed while turning toward the force.
    #[modulation(default = 0.1, unit = "m/s", min = 0.0)]
    slow: Modulation<f64>,
    /// Turn rate on the move.
    #[modulation(default = 20_f64.to_radians(), unit = "rad/s", min = 0.0)]
    veer_turn: Modulation<f64>,
    /// Turn rate on the spot.
    #[modulation(default = 50_f64.to_radians(), unit = "rad/s", min = 0.0)]
    turn: Modulation<f64>,
    /// Heading error below which it goes straight.
    #[modulation(default = 10_f64.to_radians(), unit = "rad", min = 0.0, max = 3.15)]
    straight: Modulation<f64>,
    /// Heading error below which it turns on the move.
    #[modulation(default = 40_f64.to_radians(), unit = "rad", min = 0.0, max = 3.15)]
    veer: Modulation<f64>,
    /// Weight of the target's pull.
    #[modulation(default = 0.7, min = 0.0)]
    attraction: Modulation<f64>,
    /// Weight of the obstacles' push.
    #[modulation(default = 0.3, min = 0.0)]
    repulsion: Modulation<f64>,
    /// Distance beyond which the target's pull no longer grows.
    #[modulation(default = 1.0, unit = "m", min = 0.0)]
    cap: Modulation<f64>,
    /// Factor on the distances at which obstacles push. 1 gives the table of 2007, which reaches 3 m.
    #[modulation(default = 1.0, min = 0.01)]
    reach: Modulation<f64>,
    /// Speeds of the base.
    #[actuator]
    base: Actuator<Twist>,
    obstacle: bool,
    /// How much larger the area was at the last check, m.
    checked_margin: f64,
}

impl Schema for Vff {
    fn check(&mut self, cx: &Context) -> Result<Precondition> {
        let (Some(laser), Some(heading)) = (self.laser.get(cx), self.heading(cx)) else {
            return Ok(false.into());
        };
        let margin = self.current_margin(cx);
        self.checked_margin = margin;
        let nearest = laser.nearest_ahead(self.half_width.get(cx) + margin);
        self.obstacle = nearest.is_some_and(|ahead| ahead <= self.ahead.get(cx) + margin);
        Ok(Precondition::from(self.obstacle).urgency(heading.abs()))
    }

    fn iterate(&mut self, cx: &Context) -> Result {
        let twist = match self.heading(cx) {
            None => Twist::ZERO,
            Some(error) if error.abs() < self.straight.get(cx) => Twist::planar(self.fast.get(cx), 0.0),
            Some(error) if error.abs() < self.veer.get(cx) => {
                Twist::planar(self.slow.get(cx), self.veer_turn.get(cx).copysign(error))
            }
            Some(error) => Twist::planar(0.0, self.turn.get(cx).copysign(error)),
        };
        self.base.command(cx, twist);
        Ok(())
    }
}

/// Saves whether an obstacle was in the area, because the size of the area depends on it.
impl Memory for Vff {
    fn save(&self, _: &Context, saving: &mut Saving) {
        saving.put(&u8::from(self.obstacle));
    }

    fn restore(&mut self, _: &Context, saved: &mut Saved) -> Result {
        self.obstacle = saved.take::<u8>()? != 0;
        Ok(())
    }
}

impl Vff {
    /// Angle to the left by which to turn toward the sum of forces, rad; `None` without a target, a pose or a
    /// scan.
    fn heading(&self, cx: &Context) -> Option<f64> {
        let (x, y) = self.forces(cx)?.sum();
        Some(libm::atan2(y, x))
    }

    fn forces(&self, cx: &Context) -> Option<Forces> {
        let field = FieldWeights {
            attraction: self.attraction.get(cx),
            repulsion: self.repulsion.get(cx),
            cap: self.cap.get(cx),
            reach: self.reach.get(cx),
        };
        Some(field.forces(&self.local_target(cx)?, self.laser.get(cx)?.value()))
    }

    /// The target in the robot's frame.
    fn local_target(&self, cx: &Context) -> Option<Pose2D> {
        let target = self.target.get(cx).get()?;
        Some(self.pose.get(cx)?.pose2d().localize(&target))
    }

    /// How much larger the area is at present, m.
    fn current_margin(&self, cx: &Context) -> f64 {
        if self.obstacle { self.margin.get(cx) } else { 0.0 }
    }
}

jde_schema::export!(
    "vff",
    "Drives around obstacles toward a target by virtual forces.",
    [Vff]
);

#[cfg(test)]
mod tests;
