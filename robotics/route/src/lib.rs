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
use jde_schema::types::normalize_angle;

pub use progress::{Progress, Stuck};

/// The modulations of a father that leads through targets.
pub struct Terms<'call> {
    /// The targets, one after another, in the frame of the odometry.
    pub route: Sample<'call, Route>,
    /// How many times to go through the targets; 0 for no limit.
    pub rounds: u32,
    /// Distance to a target below which it counts as reached, m.
    pub tolerance: f64,
    /// Error of the heading of a target below which it counts as reached, rad; π accepts any heading.
    pub yaw_tolerance: f64,
    /// Whether the targets of the route before the last one are passed, with any heading.
    pub passes_through: bool,
    /// How long the robot waits at each target of the route, s. It waits at none that it passes.
    pub pause: f64,
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
    /// Targets of the route that were reached.
    reached: u32,
    /// Chosen targets that were reached, which are none of the route.
    chosen_reached: u32,
    /// Targets of the route that counted as out of reach.
    skipped: u32,
    progress: Progress,
    /// Until when it waits at a target of the route.
    waits_until: Option<Duration>,
    request: Option<TargetRequest>,
    ended: Option<Ended>,
}

/// The last chosen target that was reached or given up. While it is the chosen one, the mission has its state.
#[derive(Debug)]
struct Ended {
    target: Target,
    state: u8,
    note: Text<64>,
}

/// A target set on the panel, and the operator that set it.
#[derive(Debug)]
struct TargetRequest {
    position: Pose2D,
    operator: String,
}

impl Ended {
    /// Whether this is the target that ended, to the bit: one whose heading begins to count is another, and one without
    /// numbers is the same.
    fn is(&self, chosen: &Target) -> bool {
        self.target.as_bytes() == chosen.as_bytes()
    }

    /// Where it was; the zero if that is no place.
    fn pose(&self) -> Pose2D {
        Some(self.target.pose)
            .filter(Pose2D::is_finite)
            .unwrap_or_default()
    }
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

    /// Returns whether the heading of the current target counts.
    fn has_heading(&self, terms: &Terms<'_>) -> bool {
        match (&self.request, &terms.chosen) {
            (Some(_), _) => false,
            (None, Some(chosen)) => chosen.has_heading.get(),
            (None, None) => terms.yaw_tolerance < core::f64::consts::PI && !self.is_passed(terms),
        }
    }

    /// Whether the robot waits at a target of the route, and nobody wants it elsewhere.
    fn waits(&self, terms: &Terms<'_>) -> bool {
        self.waits_until.is_some() && self.request.is_none() && terms.chosen.is_none()
    }

    /// Whether the robot passes the next target of the route on its way to the last one.
    fn is_passed(&self, terms: &Terms<'_>) -> bool {
        terms.passes_through && self.passed().saturating_add(1) != Self::total(terms)
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
        self.ended
            .take_if(|ended| terms.chosen.is_none_or(|chosen| !ended.is(&chosen)));
        self.refuse(cx, terms);
        self.waits_until.take_if(|until| cx.now() >= *until);
        if let Some(target) = self.current(terms).filter(|_| !self.waits(terms)) {
            let distance = pose.distance_to(&target);
            let error = normalize_angle(target.theta - pose.theta).abs();
            let faces = error <= terms.yaw_tolerance || !self.has_heading(terms);
            let is_there = distance < terms.tolerance || terms.is_at_end;
            if is_there && faces {
                self.arrive(cx, terms, target);
            } else {
                let patience = Duration::try_from_secs_f64(terms.patience).unwrap_or_default();
                if let Some(stuck) = self.progress.stuck(cx.now(), &target, distance, patience) {
                    let Stuck { waited, nearest } = stuck;
                    let waited = waited.as_secs_f64();
                    let reason = if is_there {
                        let off = error.to_degrees();
                        format!(
                            "it is there, but {off:.0} deg off its heading: `yaw_goal_tolerance` of what drives must not be larger"
                        )
                    } else {
                        format!("it came no nearer than {nearest:.2} m for {waited:.0} s")
                    };
                    self.give_up(cx, terms, &reason, obstacle);
                }
            }
        }
        let target = self.current(terms);
        let child_target = match target {
            Some(_) if self.waits(terms) => Target::NONE,
            Some(target) if self.has_heading(terms) => Target::facing(target),
            Some(target) => Target::at(target),
            None => Target::NONE,
        };
        let ended = self.ended.as_ref().filter(|_| target.is_none());
        let mission = Mission {
            state: ended.map_or_else(|| self.state(terms, target), |ended| ended.state),
            reached: if terms.route.poses.is_empty() {
                self.chosen_reached
            } else {
                self.reached
            },
            total: Self::total(terms),
            target: ended.map_or(target.unwrap_or_default(), Ended::pose),
            distance: target.map_or(0.0, |target| pose.distance_to(&target)),
            note: ended.map_or_else(|| self.note(terms, target), |ended| ended.note),
            ..Mission::default()
        };
        (child_target, mission)
    }

    /// Gives up a chosen target that is no place.
    fn refuse(&mut self, cx: &Context, terms: &Terms<'_>) {
        let is_no_place = |chosen: &Target| chosen.get().is_some_and(|pose| !pose.is_finite());
        if let Some(chosen) = terms.chosen.filter(is_no_place)
            && self.ended.is_none()
        {
            let reason = "its numbers are not finite";
            warn!(cx, "gives up the chosen target: {reason}");
            self.end(chosen, Mission::FAILED, reason);
        }
    }

    /// Gives up the current target, for a reason in words, and continues without it. `obstacle` is why the robot stands, if
    /// that is known.
    pub fn give_up(&mut self, cx: &Context, terms: &Terms<'_>, reason: &str, obstacle: Option<&str>) {
        let Some(Pose2D { x, y, .. }) = self.current(terms) else {
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
        if let Some(chosen) = terms.chosen {
            warn!(cx, "gives up the chosen target at {x:.2}, {y:.2}: {reason}");
            self.end(chosen, Mission::FAILED, &reason);
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
            let has_ended = self.ended.as_ref().is_some_and(|ended| ended.is(&chosen));
            return chosen.get().filter(|target| target.is_finite() && !has_ended);
        }
        let passed = self.passed();
        let continues = terms.rounds == 0 || passed < Self::total(terms);
        let index = passed as usize % terms.route.poses.len().max(1);
        let next = terms.route.poses.get(index).copied();
        next.filter(|_| continues && !self.has_failed(terms))
    }

    /// How many targets of the route are behind it.
    fn passed(&self) -> u32 {
        self.reached.saturating_add(self.skipped)
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

    /// The note of the mission on its way to a target: that the robot waits, or how many targets of a route were out of reach.
    fn note(&self, terms: &Terms<'_>, target: Option<Pose2D>) -> Text<64> {
        match self.skipped {
            _ if terms.chosen.is_some() => Text::EMPTY,
            _ if target.is_some() && self.waits(terms) => Text::new("waits at the target"),
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

    fn end(&mut self, target: Target, state: u8, words: &str) {
        let note = Text::truncated(words);
        self.ended = Some(Ended { target, state, note });
    }

    fn arrive(&mut self, cx: &Context, terms: &Terms<'_>, target: Pose2D) {
        let Pose2D { x, y, .. } = target;
        if let Some(TargetRequest { operator, .. }) = self.request.take() {
            info!(cx, "reached the target of {operator} at {x:.2}, {y:.2}");
        } else if let Some(chosen) = terms.chosen {
            self.chosen_reached += 1;
            info!(cx, "reached the chosen target at {x:.2}, {y:.2}");
            self.end(chosen, Mission::DONE, "");
        } else {
            let pause = Duration::try_from_secs_f64(terms.pause).unwrap_or_default();
            if !pause.is_zero() && !self.is_passed(terms) {
                self.waits_until = Some(cx.now() + pause);
            }
            self.reached += 1;
            info!(cx, "reached target {} at {x:.2}, {y:.2}", self.reached);
        }
    }
}
