//! The father that leads a robot along planned paths: one target after another, or the one clicked on its
//! panel. It plans nothing and commands no actuator itself.

mod memory;
mod panel;

use core::time::Duration;

use jde_route::{Targets, Terms};
use jde_schema::prelude::*;
use jde_schema::types::{Lanes, OccupancyGrid, Zones};

/// After so long with checks and no iteration, somebody else drives.
const ELSEWHERE: Duration = Duration::from_secs(1);

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
    /// The words of the planner.
    #[import(optional)]
    state: Import<Text<160>>,
    /// The mission of the planner. If it fails, the target is given up.
    #[import(optional)]
    planning: Import<Mission>,
    /// The mission of a recovery. If it fails, the target is given up.
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
    /// Number of rounds through the targets; 0 for no limit.
    #[modulation(default = 1)]
    rounds: Modulation<u32>,
    /// Distance to a target below which it counts as reached.
    #[modulation(default = 0.3, unit = "m", min = 0.01, was = "tolerance")]
    xy_goal_tolerance: Modulation<f64>,
    /// Error of the heading of a target below which it counts as reached; "180 deg" accepts any heading. A place that
    /// is clicked, or chosen without a heading, has any.
    #[modulation(default = 0.25, unit = "rad", min = 0.01)]
    yaw_goal_tolerance: Modulation<f64>,
    /// Whether it passes the targets of the route before the last one, whatever the heading there. Without a limit of
    /// rounds it passes all.
    #[modulation(default = false)]
    through_poses: Modulation<bool>,
    /// Time for which it waits at each target of the route that it does not pass.
    #[modulation(default = 0.0, unit = "s", min = 0.0, max = 86400.0)]
    waypoint_pause_duration: Modulation<f64>,
    /// Greatest distance from a target that no way reaches at which the path may end. At its end the target then
    /// counts as reached. A value above 0 replaces the `tolerance` of the planner.
    #[modulation(default = 0.0, unit = "m", min = 0.0, max = 5.0)]
    nearby: Modulation<f64>,
    /// Time for which it may lead without getting nearer to a target, which then counts as out of reach; 0
    /// for no limit.
    #[modulation(default = 60.0, unit = "s", min = 0.0)]
    patience: Modulation<f64>,
    /// Number of targets that may be out of reach before the mission fails. Up to that number it continues with the
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
    /// The numbers of the last failures of the planner and of a recovery.
    failures: [u64; 2],
    /// The tolerance that the planner has from here; 0 if it has had its own only.
    stated: f64,
    /// The target that the planner has, and since when.
    planned: (Option<Pose2D>, Duration),
    /// Whether nobody drives: there is no target, or not yet a path to the one after it.
    rests: bool,
    /// When it was first checked since its last iteration.
    checked: Option<Duration>,
}

impl Schema for Navigate {
    fn awake(&mut self, _: &Context) -> Result {
        self.targets.forget_chosen();
        Ok(())
    }

    /// A sibling that drives, such as a person, takes the robot from it without a sleep.
    fn check(&mut self, cx: &Context) -> Result<Precondition> {
        let since = *self.checked.get_or_insert(cx.now());
        if self.planned.0.is_some() && cx.now().saturating_sub(since) > ELSEWHERE {
            self.pause(cx);
        }
        Ok(true.into())
    }

    fn sleep(&mut self, cx: &Context) {
        self.pause(cx);
    }

    fn iterate(&mut self, cx: &Context) -> Result {
        self.checked = None;
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
    /// While another schema drives, or a person, nobody waits for a way to the target.
    fn pause(&mut self, cx: &Context) {
        self.target.set(cx, Target::NONE);
        self.planned.0 = None;
        self.rests = true;
    }

    /// Leads a robot that knows where it is.
    fn lead(&mut self, cx: &Context, terms: &mut Terms, pose: Pose2D) {
        let target = self.targets.current(terms);
        if self.planned.0 != target {
            self.planned = (target, cx.now());
        }
        let planner = self.state.get(cx);
        let words = planner.as_ref().map(|state| state.as_str());
        self.take_failures(cx, terms, words);
        let nearby = self.nearby.get(cx);
        if core::mem::replace(&mut self.stated, nearby) != nearby {
            self.plan_tolerance.set(cx, nearby);
        }
        terms.is_at_end = self.is_at_end(cx, terms, pose);
        let (target, mission) = self.targets.advance(cx, terms, pose, words);
        self.target.set(cx, target);
        self.mission.write(cx, mission);
        self.rests = match target.get() {
            None => {
                self.planned.0 = None;
                true
            }
            // The path that there still is leads to a target that is gone.
            Some(_) => self.rests && self.new_path(cx).is_none() && !self.is_without_way(cx),
        };
    }

    /// Whether the planner has no path to the current target, as it says itself if its words are bound.
    fn is_without_way(&self, cx: &Context) -> bool {
        let has_answered = match self.state.get(cx) {
            Some(state) => state.time() > self.planned.1,
            None => true,
        };
        has_answered && self.path.get(cx).is_none()
    }

    /// Gives up the target for which the planner or a recovery has failed, with the words of the planner.
    fn take_failures(&mut self, cx: &Context, terms: &Terms, words: Option<&str>) {
        // The words of the planner are its reason already.
        let sources = [(&self.planning, None), (&self.recovery, words)];
        for ((import, words), last) in sources.into_iter().zip(&mut self.failures) {
            // What was said before the planner had the target is of an earlier drive.
            let is_of_now = |mission: &Sample<'_, Mission>| {
                mission.state == Mission::FAILED && mission.time() >= self.planned.1
            };
            let Some(mission) = import.get(cx).filter(is_of_now) else {
                continue;
            };
            let is_old = core::mem::replace(last, mission.sequence()) == mission.sequence();
            if !is_old && self.targets.current(terms) == Some(mission.target) {
                self.targets.give_up(cx, terms, mission.note.as_str(), words);
            }
        }
    }

    /// The path to the current target. One that is older than the target leads to another.
    fn new_path<'cx>(&self, cx: &'cx Context) -> Option<Sample<'cx, Path>> {
        let path = self.path.get(cx);
        path.filter(|path| Duration::from(path.header.stamp) > self.planned.1)
    }

    /// Whether the robot is at the end of a path that ends near the current target.
    fn is_at_end(&self, cx: &Context, terms: &Terms, pose: Pose2D) -> bool {
        let target = self.targets.current(terms);
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
            tolerance: self.xy_goal_tolerance.get(cx),
            yaw_tolerance: self.yaw_goal_tolerance.get(cx),
            passes_through: self.through_poses.get(cx),
            pause: self.waypoint_pause_duration.get(cx),
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
