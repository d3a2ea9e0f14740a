//! The father of safe navigation (the paper, section 5). It has no precondition, modulates its children with
//! one target after another, and arbitrates between them. It commands no actuator itself. A target clicked on
//! its panel takes precedence over the route.

mod memory;
mod panel;

use jde_route::{Targets, Terms};
use jde_schema::prelude::*;

/// Leads the robot through its targets by waking and modulating three children.
///
/// Its own arbitration is that of 2007, in which `brake` wins every collision, with one exception that
/// `turning` can permit: an `avoid` that would turn on the spot wins against `brake`.
#[derive(Describe)]
#[schema(motor, period = "75ms", budget = "20ms")]
pub struct Example {
    /// The estimated pose of the robot.
    #[import]
    pose: Import<Odometry>,
    /// The scan of the laser, used only by the panel.
    #[import(optional)]
    laser: Import<LaserScan>,
    /// How far ahead the area of `avoid` reaches. Only the panel uses this import and the next three.
    #[import(optional, unit = "m")]
    avoid_ahead: Import<f64>,
    /// Half the width of that area.
    #[import(optional, unit = "m")]
    avoid_half_width: Import<f64>,
    /// How far ahead the area of `brake` reaches.
    #[import(optional, unit = "m")]
    brake_ahead: Import<f64>,
    /// Half the width of that area.
    #[import(optional, unit = "m")]
    brake_half_width: Import<f64>,
    /// The targets, one after another, in the frame of the odometry.
    #[modulation(default = Route::EMPTY)]
    route: Modulation<Route>,
    /// How many times to go through the targets; 0 for no limit.
    #[modulation(default = 1)]
    rounds: Modulation<u32>,
    /// Distance to a target below which it counts as reached.
    #[modulation(default = 0.3, unit = "m", min = 0.01)]
    tolerance: Modulation<f64>,
    /// Time for which it may lead without getting nearer to a target, which then counts as out of reach; 0
    /// for no limit.
    #[modulation(default = 60.0, unit = "s", min = 0.0)]
    patience: Modulation<f64>,
    /// How many targets may be out of reach before the mission fails. Up to that number it continues with the
    /// next target.
    #[modulation(default = 0)]
    skips: Modulation<u32>,
    /// Heading error from which `avoid` turns on the spot and may win against `brake`. The default never
    /// permits it.
    #[modulation(default = 7.0, unit = "rad", min = 0.0, max = 7.0)]
    turning: Modulation<f64>,
    /// Progress of the mission: targets reached in all rounds, and their total, which is 0 if the rounds have
    /// no limit.
    #[export(lasting)]
    mission: Export<Mission>,
    /// Brakes before an obstacle that is very close.
    #[child(group = "base")]
    brake: Child,
    /// Drives around a close obstacle.
    #[child(group = "base")]
    avoid: Child,
    /// Drives straight to the target.
    #[child(group = "base")]
    cruise: Child,
    /// Target of `avoid`.
    #[modulates(child = "avoid", name = "target")]
    avoid_target: Modulates<Target>,
    /// Target of `cruise`.
    #[modulates(child = "cruise", name = "target")]
    cruise_target: Modulates<Target>,
    targets: Targets,
}

impl Schema for Example {
    fn iterate(&mut self, cx: &Context) -> Result {
        for child in [&self.brake, &self.avoid, &self.cruise] {
            child.wake(cx);
        }
        let Some(pose) = self.pose.get(cx).map(|odometry| odometry.pose2d()) else {
            return Ok(());
        };
        let terms = self.terms(cx);
        let (target, mission) = self.targets.advance(cx, &terms, pose, None);
        self.avoid_target.set(cx, target);
        self.cruise_target.set(cx, target);
        self.mission.write(cx, mission);
        Ok(())
    }
}

impl Example {
    fn terms<'call>(&self, cx: &'call Context<'_>) -> Terms<'call> {
        Terms {
            route: self.route.sample(cx),
            rounds: self.rounds.get(cx),
            tolerance: self.tolerance.get(cx),
            yaw_tolerance: core::f64::consts::PI,
            passes_through: false,
            pause: 0.0,
            patience: self.patience.get(cx),
            skips: self.skips.get(cx),
            chosen: None,
            is_at_end: false,
        }
    }
}

impl Arbitrate for Example {
    fn arbitrate(&mut self, cx: &Context, level: &Level) -> Result<Verdict> {
        if level.case() == Case::Absence {
            return Ok(Verdict::nobody("no child is ready"));
        }
        let turns = level
            .candidate(&self.avoid)
            .is_some_and(|avoid| avoid.ready && avoid.urgency >= self.turning.get(cx));
        let verdict = if turns {
            Verdict::choose(
                &self.avoid,
                "it turns on the spot, which is safe under the brake's nose",
            )
        } else if level.is_ready(&self.brake) {
            Verdict::choose(&self.brake, "on overlap the brake wins")
        } else if level.is_ready(&self.avoid) {
            Verdict::choose(&self.avoid, "something is in the way")
        } else {
            Verdict::choose(&self.cruise, "the way is free")
        };
        Ok(verdict)
    }
}

jde_schema::export!("example", "The father of safe navigation.", [Example]);

#[cfg(test)]
mod tests;
