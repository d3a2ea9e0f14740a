//! The father that leads a robot along planned paths: one target after another, or the one clicked on its
//! panel. It plans nothing and commands no actuator itself.

mod memory;
mod panel;

use core::time::Duration;

use jde_route::{Targets, Terms};
use jde_schema::prelude::*;
use jde_schema::types::{Lanes, OccupancyGrid, Zones};

/// Leads the robot through its targets: it gives each to a planner, and wakes the schemas that drive along the
/// planner's path.
///
/// The children that drive compete; the order in the application is their priority. A target to which the
/// robot comes no nearer for `patience` is given up, with the words of the planner.
#[derive(Describe)]
#[schema(motor, period = "100ms", budget = "20ms")]
pub struct Navigate {
    /// The estimated pose of the robot, in the frame of the map. One that is not finite counts as none.
    #[import]
    pose: Import<Odometry>,
    /// The target that another schema chooses, in the frame of the map. While it has a value, it takes the place of the
    /// route: the mission is DONE or FAILED for this target, until another one or none is chosen, or the father awakes again.
    #[import(optional)]
    chosen: Import<Target>,
    /// What the planner says.
    #[import(optional)]
    state: Import<Text<160>>,
    /// What a recovery does. If it fails, the target is given up.
    #[import(optional)]
    recovery: Import<Mission>,
    /// The map, used only by the panel.
    #[import(optional)]
    map: Import<OccupancyGrid>,
    /// The planned path, used by the panel, and for a target that cannot be reached exactly.
    #[import(optional)]
    path: Import<Path>,
    /// The keep-out zones of the planner, used only by the panel.
    #[import(optional)]
    zones: Import<Zones>,
    /// The lanes of the planner, used only by the panel.
    #[import(optional)]
    lanes: Import<Lanes>,
    /// The scan of the laser, used only by the panel.
    #[import(optional)]
    laser: Import<LaserScan>,
    /// The targets, one after another, in the frame of the map.
    #[modulation(default = Route::EMPTY)]
    route: Modulation<Route>,
    /// How many times to go through the targets; 0 for no limit.
    #[modulation(default = 1)]
    rounds: Modulation<u32>,
    /// Distance to a target below which it counts as reached.
    #[modulation(default = 0.3, unit = "m", min = 0.01)]
    tolerance: Modulation<f64>,
    /// How far from a target that no way reaches the path may end. At its end the target then counts as reached.
    /// A value above 0 replaces the `tolerance` of the planner.
    #[modulation(default = 0.0, unit = "m", min = 0.0, max = 5.0)]
    nearby: Modulation<f64>,
    /// Time for which it may lead without getting nearer to a target, which then counts as out of reach; 0
    /// for no limit.
    #[modulation(default = 60.0, unit = "s", min = 0.0)]
    patience: Modulation<f64>,
    /// How many targets may be out of reach before the mission fails. Up to that number it continues with the
    /// next target.
    #[modulation(default = 0)]
    skips: Modulation<u32>,
    /// Progress of the mission: targets reached in all rounds, and their total, which is 0 if the rounds have
    /// no limit.
    #[export(lasting)]
    mission: Export<Mission>,
    /// Plans the path to the target.
    #[child(perceptive)]
    plan: Child,
    /// The target of the planner.
    #[modulates(child = "plan", name = "target")]
    target: Modulates<Target>,
    /// How far from a target that no way reaches the planner may end its path, m.
    #[modulates(child = "plan", name = "tolerance", optional)]
    plan_tolerance: Modulates<f64>,
    /// Drive along the path.
    #[child(group = "base")]
    drive: Children,
    targets: Targets,
    /// The number of the last failure of a recovery.
    failure: u64,
    /// The tolerance that the planner has from here; 0 if it has had its own only.
    stated: f64,
    /// The current target, and since when.
    planned: (Option<Pose2D>, Duration),
    /// Whether nobody drives: there is no target, or not yet a path to the one after it.
    rests: bool,
}

impl Schema for Navigate {
    fn awake(&mut self, _: &Context) -> Result {
        self.targets.forget_chosen();
        Ok(())
    }

    fn iterate(&mut self, cx: &Context) -> Result {
        self.plan.wake(cx);
        let mut terms = self.terms(cx);
        let pose = self.pose.get(cx).map(|odometry| odometry.pose2d());
        let rests = match pose.filter(Pose2D::is_finite) {
            Some(pose) => {
                self.lead(cx, &mut terms, pose);
                self.rests
            }
            // A robot that does not know where it is may have to move to find out.
            None => {
                let is_idle = self.targets.current(&terms).is_none();
                self.rests |= is_idle;
                is_idle
            }
        };
        if rests {
            self.drive.sleep(cx);
        } else {
            self.drive.wake(cx);
        }
        Ok(())
    }
}

impl Navigate {
    /// Leads a robot that knows where it is.
    fn lead(&mut self, cx: &Context, terms: &mut Terms, pose: Pose2D) {
        let planner = self.state.get(cx);
        let words = planner.as_ref().map(|state| state.as_str());
        self.take_failure(cx, terms, words);
        let nearby = self.nearby.get(cx);
        if core::mem::replace(&mut self.stated, nearby) != nearby {
            self.plan_tolerance.set(cx, nearby);
        }
        terms.is_at_end = self.is_at_end(cx, terms, pose);
        let (target, mission) = self.targets.advance(cx, terms, pose, words);
        self.target.set(cx, target);
        self.mission.write(cx, mission);
        self.rests = match target.get() {
            None => true,
            // The path that there still is leads to a target that is gone.
            Some(_) => self.rests && self.path.get(cx).is_some() && self.new_path(cx).is_none(),
        };
    }

    /// Gives up the target for which a recovery has failed, with the words of the planner.
    fn take_failure(&mut self, cx: &Context, terms: &Terms, words: Option<&str>) {
        let Some(recovery) = self.recovery.get(cx) else {
            return;
        };
        if recovery.state != Mission::FAILED
            || core::mem::replace(&mut self.failure, recovery.sequence()) == recovery.sequence()
        {
            return;
        }
        if self.targets.current(terms) == Some(recovery.target) {
            self.targets.give_up(cx, terms, recovery.note.as_str(), words);
        }
    }

    /// The path to the current target. One that is older than the target leads to another.
    fn new_path<'cx>(&self, cx: &'cx Context) -> Option<Sample<'cx, Path>> {
        let path = self.path.get(cx);
        path.filter(|path| Duration::from(path.header.stamp) > self.planned.1)
    }

    /// Whether the robot is at the end of a path that ends near the current target.
    fn is_at_end(&mut self, cx: &Context, terms: &Terms, pose: Pose2D) -> bool {
        let target = self.targets.current(terms);
        if self.planned.0 != target {
            self.planned = (target, cx.now());
        }
        let path = self.new_path(cx);
        let end = path.as_ref().and_then(|path| path.poses.last());
        target.zip(end).is_some_and(|(target, end)| {
            let end = Pose2D::from(end.pose);
            end.distance_to(&target) <= self.nearby.get(cx) && pose.distance_to(&end) < terms.tolerance
        })
    }

    fn terms<'call>(&self, cx: &'call Context<'_>) -> Terms<'call> {
        Terms {
            route: self.route.sample(cx),
            rounds: self.rounds.get(cx),
            tolerance: self.tolerance.get(cx),
            patience: self.patience.get(cx),
            skips: self.skips.get(cx),
            chosen: self.chosen.get(cx).map(|target| *target),
            is_at_end: false,
        }
    }
}

jde_schema::export!(
    "navigate",
    "Leads a robot along planned paths to its targets.",
    [Navigate]
);

#[cfg(test)]
mod tests;
