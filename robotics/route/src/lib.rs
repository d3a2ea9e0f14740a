//! What fathers share that lead a robot through targets: which target is next, which are out of reach, what an
//! operator wants first, and the state of the mission.
//!
//! It drives nothing and knows no map.

mod memory;
mod panel;
mod progress;

use core::time::Duration;

use jde_schema::Sample;
use jde_schema::prelude::*;

use progress::{Progress, Stuck};

/// The modulations of a father that leads through targets.
pub struct Terms<'call> {
    /// The targets, one after another, in the frame of the odometry.
    pub route: Sample<'call, Route>,
    /// How many times to go through the targets; 0 for no limit.
    pub rounds: u32,
    /// Distance to a target below which it counts as reached, m.
    pub tolerance: f64,
    /// Time for which the robot may not get nearer to a target, which then counts as out of reach, s; 0 for
    /// no limit.
    pub patience: f64,
    /// How many targets may be out of reach before the mission fails.
    pub skips: u32,
    /// The target that another schema chooses, in the place of the route; `None` if none chooses.
    pub chosen: Option<Target>,
    /// Whether the robot is where its way to the current target ends. The target then counts as reached.
    pub is_at_end: bool,
}

/// The progress through the targets.
#[derive(Debug, Default)]
pub struct Targets {
    reached: u32,
    /// Targets of the route that counted as out of reach.
    skipped: u32,
    progress: Progress,
    request: Option<TargetRequest>,
    ended: Option<Ended>,
}

/// The last chosen target that was reached or given up. While it is the chosen one, the mission has its state.
#[derive(Debug)]
struct Ended {
    target: Pose2D,
    state: u8,
    note: Text<64>,
}

/// A target set on the panel, and the operator that set it.
#[derive(Debug)]
struct TargetRequest {
    position: Pose2D,
    operator: String,
}

impl Targets {
    /// Forgets what became of the last chosen target: it is driven to again.
    pub fn forget_chosen(&mut self) {
        self.ended = None;
    }

    /// Sets a target of an operator, which takes precedence over the route.
    fn request(&mut self, position: Pose2D, operator: &str) {
        self.request = Some(TargetRequest {
            position,
            operator: operator.to_owned(),
        });
    }

    /// Returns the current target: that of an operator, or else the next of the route.
    #[must_use]
    pub fn current(&self, terms: &Terms<'_>) -> Option<Pose2D> {
        let request = self.request.as_ref().map(|request| request.position);
        request.or_else(|| self.next(terms))
    }

    /// Takes the robot's present pose: targets are reached, or given up. Logs both, with `obstacle`, a reason
    /// in words why the robot stands, if there is one. Returns the target to drive to and the mission.
    pub fn advance(
        &mut self,
        cx: &Context,
        terms: &Terms<'_>,
        pose: Pose2D,
        obstacle: Option<&str>,
    ) -> (Target, Mission) {
        let chosen = terms.chosen.and_then(|chosen| chosen.get());
        self.ended.take_if(|ended| Some(ended.target) != chosen);
        if let Some(target) = self.current(terms) {
            let distance = pose.distance_to(&target);
            if distance < terms.tolerance || terms.is_at_end {
                self.arrive(cx, terms, target);
            } else {
                let patience = Duration::try_from_secs_f64(terms.patience).unwrap_or_default();
                if let Some(stuck) = self.progress.stuck(cx.now(), &target, distance, patience) {
                    let Stuck { waited, nearest } = stuck;
                    let waited = waited.as_secs_f64();
                    let reason = format!("it came no nearer than {nearest:.2} m for {waited:.0} s");
                    self.give_up(cx, terms, &reason, obstacle);
                }
            }
        }
        let target = self.current(terms);
        let child_target = target.map_or(Target::NONE, Target::at);
        let ended = self.ended.as_ref().filter(|_| target.is_none());
        let mission = Mission {
            state: ended.map_or_else(|| self.state(terms, target), |ended| ended.state),
            reached: self.reached,
            total: Self::total(terms),
            target: ended.map_or(child_target.pose, |ended| ended.target),
            distance: target.map_or(0.0, |target| pose.distance_to(&target)),
            note: ended.map_or_else(|| self.note(terms), |ended| ended.note),
            ..Mission::default()
        };
        (child_target, mission)
    }

    /// Gives up the current target, for a reason in words, and continues without it. `obstacle` is why the robot stands, if
    /// that is known.
    pub fn give_up(&mut self, cx: &Context, terms: &Terms<'_>, reason: &str, obstacle: Option<&str>) {
        let Some(Pose2D { x, y, theta }) = self.current(terms) else {
            return;
        };
        let obstacle = obstacle.map(|words| format!(" ({words})")).unwrap_or_default();
        let reason = format!("{reason}{obstacle}");
        if let Some(TargetRequest { operator, .. }) = self.request.take() {
            warn!(
                cx,
                "gives up the target of {operator} at {x:.2}, {y:.2}: {reason}"
            );
            return;
        }
        if terms.chosen.is_some() {
            warn!(cx, "gives up the chosen target at {x:.2}, {y:.2}: {reason}");
            self.end(Pose2D { x, y, theta }, Mission::FAILED, &reason);
            return;
        }
        self.skipped += 1;
        let consequence = if self.has_failed(terms) {
            "the mission fails"
        } else {
            "on to the next"
        };
        warn!(
            cx,
            "gives up the target at {x:.2}, {y:.2}: {reason}; {consequence}"
        );
    }

    /// The chosen target unless it has ended, or else the next one of the route; `None` after the last one, or after
    /// the mission failed.
    fn next(&self, terms: &Terms<'_>) -> Option<Pose2D> {
        if let Some(chosen) = terms.chosen {
            let has_ended =
                |target: &Pose2D| self.ended.as_ref().is_some_and(|ended| ended.target == *target);
            return chosen.get().filter(|target| !has_ended(target));
        }
        let passed = self.reached.saturating_add(self.skipped);
        let continues = terms.rounds == 0 || passed < Self::total(terms);
        let index = passed as usize % terms.route.poses.len().max(1);
        let next = terms.route.poses.get(index).copied();
        next.filter(|_| continues && !self.has_failed(terms))
    }

    /// The state of a mission along a route, or to a chosen target that has not ended.
    fn state(&self, terms: &Terms<'_>, target: Option<Pose2D>) -> u8 {
        if terms.chosen.is_some() {
            Mission::RUNNING
        } else if self.has_failed(terms) {
            Mission::FAILED
        } else if target.is_none() && !terms.route.poses.is_empty() {
            Mission::DONE
        } else {
            Mission::RUNNING
        }
    }

    /// Whether more targets were out of reach than permitted.
    fn has_failed(&self, terms: &Terms<'_>) -> bool {
        self.skipped > terms.skips
    }

    /// The note of the mission: how many targets of a route were out of reach.
    fn note(&self, terms: &Terms<'_>) -> Text<64> {
        match self.skipped {
            _ if terms.chosen.is_some() => Text::EMPTY,
            0 => Text::EMPTY,
            1 => Text::new("1 target was out of reach"),
            several => Text::truncated(&format!("{several} targets were out of reach")),
        }
    }

    /// Number of targets in all rounds; 0 if the rounds have no limit.
    fn total(terms: &Terms<'_>) -> u32 {
        let targets = terms.route.poses.len() as u32;
        targets.saturating_mul(terms.rounds)
    }

    fn end(&mut self, target: Pose2D, state: u8, words: &str) {
        let note = Text::truncated(words);
        self.ended = Some(Ended { target, state, note });
    }

    fn arrive(&mut self, cx: &Context, terms: &Terms<'_>, target: Pose2D) {
        let Pose2D { x, y, .. } = target;
        if let Some(TargetRequest { operator, .. }) = self.request.take() {
            info!(cx, "reached the target of {operator} at {x:.2}, {y:.2}");
        } else {
            self.reached += 1;
            info!(cx, "reached target {} at {x:.2}, {y:.2}", self.reached);
            if terms.chosen.is_some() {
                self.end(target, Mission::DONE, "");
            }
        }
    }
}
