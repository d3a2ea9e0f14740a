//! The father of safe navigation (the paper, section 5). It has no precondition, modulates its children with
//! one target after another, and arbitrates between them. It commands no actuator itself. A target clicked on
//! its panel takes precedence over the route.

mod memory;
mod panel;
mod progress;

use core::time::Duration;

use jde_schema::prelude::*;

use progress::Progress;

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
    #[modulation(default = 7.0, unit = "rad", min = 0.0)]
    turning: Modulation<f64>,
    /// Progress of the mission: targets reached in all rounds, and their total, which is 0 if the rounds have
    /// no limit.
    #[export]
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
    reached: u32,
    /// Targets of the route that counted as out of reach.
    skipped: u32,
    progress: Progress,
    /// A target set on the panel, which takes precedence over the route.
    requested_target: Option<TargetRequest>,
}

/// A target set on the panel, and the operator that set it.
struct TargetRequest {
    position: Pose2D,
    by: String,
}

impl Schema for Example {
    fn iterate(&mut self, cx: &Context) -> Result {
        for child in [&self.brake, &self.avoid, &self.cruise] {
            child.wake(cx);
        }
        let Some(pose) = self.pose.get(cx).map(|odometry| odometry.pose2d()) else {
            return Ok(());
        };
        let target = self.target(cx);
        if let Some(target) = target
            && pose.distance_to(&target) < self.tolerance.get(cx)
        {
            self.arrive(cx, target);
        } else if let Some(target) = target {
            let patience = Duration::try_from_secs_f64(self.patience.get(cx)).unwrap_or_default();
            let distance = pose.distance_to(&target);
            if let Some(stuck) = self.progress.stuck(cx.now(), &target, distance, patience) {
                self.skip_target(cx, target, stuck);
            }
        }
        let target = self.target(cx);
        let modulation = target.map_or(Target::NONE, Target::at);
        self.avoid_target.set(cx, modulation);
        self.cruise_target.set(cx, modulation);
        let total = self.total(cx);
        let state = if self.has_failed(cx) {
            Mission::FAILED
        } else if target.is_none() && !self.route.sample(cx).poses.is_empty() {
            Mission::DONE
        } else {
            Mission::RUNNING
        };
        self.mission.write(
            cx,
            Mission {
                state,
                reached: self.reached,
                total,
                target: modulation.pose,
                distance: target.map_or(0.0, |target| pose.distance_to(&target)),
                note: self.note(),
                ..Mission::default()
            },
        );
        Ok(())
    }
}

impl Example {
    /// The current target: the one set on the panel, or else the next of the route.
    fn target(&self, cx: &Context) -> Option<Pose2D> {
        self.requested_target
            .as_ref()
            .map(|request| request.position)
            .or_else(|| self.next(cx))
    }

    /// The next target of the route; `None` after the last one, or after the mission failed.
    fn next(&self, cx: &Context) -> Option<Pose2D> {
        let route = self.route.sample(cx);
        let passed = self.reached.saturating_add(self.skipped);
        let continues = self.rounds.get(cx) == 0 || passed < self.total(cx);
        let place = passed as usize % route.poses.len().max(1);
        let next = route.poses.get(place).copied();
        next.filter(|_| continues && !self.has_failed(cx))
    }

    /// Whether more targets were out of reach than `skips` permits.
    fn has_failed(&self, cx: &Context) -> bool {
        self.skipped > self.skips.get(cx)
    }

    /// The note of the mission: how many targets were out of reach.
    fn note(&self) -> Text<64> {
        match self.skipped {
            0 => Text::EMPTY,
            1 => Text::new("1 target was out of reach"),
            several => Text::truncated(&format!("{several} targets were out of reach")),
        }
    }

    /// Number of targets in all rounds; 0 if the rounds have no limit.
    fn total(&self, cx: &Context) -> u32 {
        let targets = self.route.sample(cx).poses.len() as u32;
        targets.saturating_mul(self.rounds.get(cx))
    }

    fn arrive(&mut self, cx: &Context, target: Pose2D) {
        let Pose2D { x, y, .. } = target;
        if let Some(TargetRequest { by, .. }) = self.requested_target.take() {
            info!(cx, "reached the target of {by} at {x:.2}, {y:.2}");
        } else {
            self.reached += 1;
            info!(cx, "reached target {} at {x:.2}, {y:.2}", self.reached);
        }
    }
}

impl Example {
    /// Gives up a target that counts as out of reach, and continues without it.
    fn skip_target(&mut self, cx: &Context, target: Pose2D, stuck: progress::Stuck) {
        let Pose2D { x, y, .. } = target;
        let progress::Stuck { waited, nearest } = stuck;
        let how = format!(
            "it came no nearer than {nearest:.2} m for {:.0} s",
            waited.as_secs_f64()
        );
        if let Some(TargetRequest { by, .. }) = self.requested_target.take() {
            warn!(cx, "gives up the target of {by} at {x:.2}, {y:.2}: {how}");
            return;
        }
        self.skipped += 1;
        let then = if self.has_failed(cx) {
            "the mission fails"
        } else {
            "on to the next"
        };
        warn!(cx, "gives up the target at {x:.2}, {y:.2}: {how}; {then}");
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
