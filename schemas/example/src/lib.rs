//! The father of safe navigation (the paper, section 5): it has no precondition, gives its children one target after another,
//! and arbitrates between them. It commands no actuator itself.

use jde_schema::prelude::*;

/// Leads the robot through its targets by waking and modulating three children.
///
/// Its own arbitration is that of 2007, in which `brake` wins every collision, but for one case that can be allowed: an
/// `avoid` that would turn on the spot may do so under the brake's nose.
#[derive(Describe)]
#[schema(motor, period = "75ms", budget = "20ms")]
pub struct Example {
    /// Where the robot believes it is.
    #[import]
    pose: Import<Odometry>,
    /// The targets, one after another, in the frame of the odometry.
    #[modulation(default = Route::EMPTY)]
    route: Modulation<Route>,
    /// How often to go through the targets; 0 for ever.
    #[modulation(default = 1)]
    rounds: Modulation<u32>,
    /// How near a target must be to be reached.
    #[modulation(default = 0.3, unit = "m", min = 0.01)]
    tolerance: Modulation<f64>,
    /// Heading error from which `avoid` turns on the spot and may win against `brake`; the default never lets it.
    #[modulation(default = 7.0, unit = "rad", min = 0.0)]
    turning: Modulation<f64>,
    /// How far the mission is: targets reached in all rounds, of how many; of 0 if it goes on for ever.
    #[export]
    mission: Export<Mission>,
    /// Brakes before what is very close.
    #[child(group = "base")]
    brake: Child,
    /// Drives around what is close.
    #[child(group = "base")]
    avoid: Child,
    /// Drives straight to the target.
    #[child(group = "base")]
    cruise: Child,
    /// Where `avoid` is to go.
    #[modulates(child = "avoid", name = "target")]
    avoid_target: Modulates<Target>,
    /// Where `cruise` is to go.
    #[modulates(child = "cruise", name = "target")]
    cruise_target: Modulates<Target>,
    reached: u32,
}

impl Schema for Example {
    fn iterate(&mut self, cx: &Context) -> Result {
        for child in [&self.brake, &self.avoid, &self.cruise] {
            child.wake(cx);
        }
        let Some(pose) = self.pose.get(cx).map(|odometry| odometry.pose2d()) else {
            return Ok(());
        };
        let route = self.route.sample(cx);
        let targets = route.poses.as_slice();
        let rounds = self.rounds.get(cx);
        let total = (targets.len() as u32).saturating_mul(rounds);
        let next = |reached: u32| {
            let goes_on = rounds == 0 || reached < total;
            targets
                .get(reached as usize % targets.len().max(1))
                .filter(|_| goes_on)
        };
        if let Some(target) = next(self.reached)
            && pose.distance_to(target) < self.tolerance.get(cx)
        {
            self.reached += 1;
            info!(
                cx,
                "reached target {} at {:.2}, {:.2}", self.reached, target.x, target.y
            );
        }
        let target = next(self.reached);
        let wanted = target.map_or(Target::NONE, |target| Target::at(*target));
        self.avoid_target.set(cx, wanted);
        self.cruise_target.set(cx, wanted);
        let done = target.is_none() && !targets.is_empty();
        self.mission.write(
            cx,
            Mission {
                state: if done { Mission::DONE } else { Mission::RUNNING },
                reached: self.reached,
                total,
                target: wanted.pose,
                distance: target.map_or(0.0, |target| pose.distance_to(target)),
                ..Mission::default()
            },
        );
        Ok(())
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
