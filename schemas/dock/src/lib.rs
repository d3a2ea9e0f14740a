//! Docking at an AprilTag or a reflector. The schema avoids no obstacles: another one must brake.

mod approach;
mod effort;
mod panel;
mod reflector;
mod sighting;

use jde_motion::{Frozen, OdometryHistory, is_finite, is_jump, jumped};
use jde_schema::prelude::*;
use jde_schema::types::{Pose, PoseStamped, TagDetections, normalize_angle};
use jde_vision::CameraMount;

use approach::{Course, Manoeuvre};
use effort::Effort;
pub use reflector::{Reflector, ReflectorStrips};
use sighting::Sighting;

/// A motion after which a mark that is the same to the bit is not seen, m and rad: no sensor sees the same twice.
const REPEAT_MOTION: f64 = 0.001;
/// A reflector that is farther than this, m, from where it was is another one. A tag has a number.
const OTHER_DISTANCE: f64 = 0.5;
/// After so long a way, m, without a sighting, the odometry has drifted: the next sighting counts alone.
const DRIFT_WAY: f64 = 5.0;

/// Drives a base to a place straight before a mark, an AprilTag or a reflector, heading toward it, and away from it
/// again.
///
/// It follows the line on which the mark faces, more slowly as it comes nearer, stops, and turns toward the mark. If
/// it is too near, or near but beside the line, it drives back and begins again. The mark is kept in the frame of the
/// odometry, so it may be hidden for `patience`. The base must be able to turn on the spot. Bind either `tags` or
/// `reflector`.
///
/// READY while the mark was seen and the base is not at the docking place.
#[derive(Describe)]
#[schema(motor, period = "50ms", budget = "10ms")]
pub struct Dock {
    /// The tags that a camera of the base sees, from `tags`.
    #[import(optional)]
    tags: Import<TagDetections>,
    /// The reflector that a laser of the base sees, from `dock/reflector`.
    #[import(optional)]
    reflector: Import<PoseStamped>,
    /// The state of the schema that finds the reflector, in words.
    #[import(optional)]
    state: Import<Text<160>>,
    /// The measured pose of the base.
    #[import(trigger)]
    pose: Import<Odometry>,
    /// The number of the tag.
    #[modulation(default = 0)]
    id: Modulation<u32>,
    /// Whether it drives off instead: straight back, as far as `off`.
    #[modulation(default = Flag::FALSE)]
    leave: Modulation<Flag>,
    /// Distance from the mark to the middle of the base where it docks.
    #[modulation(default = 0.5, unit = "m", min = 0.05)]
    distance: Modulation<f64>,
    /// Distance from the mark at which it has left.
    #[modulation(default = 1.5, unit = "m", min = 0.1)]
    off: Modulation<f64>,
    /// How far it must be off the docking place to begin again. It also begins again if it is turned by 2 degrees.
    #[modulation(default = 0.05, unit = "m", min = 0.015)]
    margin: Modulation<f64>,
    /// How far the camera or the laser is ahead of the base.
    #[modulation(default = 0.0, unit = "m")]
    ahead: Modulation<f64>,
    /// How far the camera or the laser is to the left of the base.
    #[modulation(default = 0.0, unit = "m")]
    left: Modulation<f64>,
    /// How far the camera or the laser is turned to the left.
    #[modulation(default = 0.0, unit = "rad")]
    yaw: Modulation<f64>,
    /// How far the camera looks down.
    #[modulation(default = 0.0, unit = "rad")]
    tilt: Modulation<f64>,
    /// Highest speed.
    #[modulation(default = 0.2, unit = "m/s", min = 0.01, limit)]
    speed: Modulation<f64>,
    /// Highest turn rate.
    #[modulation(default = 0.8, unit = "rad/s", min = 0.01, limit)]
    turn: Modulation<f64>,
    /// Least speed at which it comes to the docking place: above that at which the base stands.
    #[modulation(default = 0.05, unit = "m/s", min = 0.005)]
    min_speed: Modulation<f64>,
    /// Least turn rate on the spot: above that at which the base stands.
    #[modulation(default = 0.1, unit = "rad/s", min = 0.005)]
    min_turn: Modulation<f64>,
    /// Error of the heading toward the mark at which it ends its turn: at least what the base turns at `min_turn` until it
    /// stands.
    #[modulation(default = 0.5_f64.to_radians(), unit = "rad", min = 0.001, max = 0.5)]
    yaw_goal_tolerance: Modulation<f64>,
    /// How long it drives without coming nearer, in all attempts to one place, before it gives up. While a guard refuses its
    /// commands, no time counts.
    #[modulation(default = 60.0, unit = "s", min = 1.0, max = 3600.0)]
    movement_time_allowance: Modulation<f64>,
    /// How long the mark may be out of sight.
    #[modulation(default = 10.0, unit = "s", min = 0.1, max = 3600.0)]
    patience: Modulation<f64>,
    /// Least step of the odometry that is a jump and no motion. A turn by more than 90 degrees is a jump too.
    #[modulation(default = 0.3, unit = "m", min = 0.1)]
    jump: Modulation<f64>,
    /// DONE while the base is at the docking place, else RUNNING; the note names the present activity. It is FAILED while a
    /// mark that was seen is out of sight for too long, and, when the drive came no nearer, until somebody moves the base.
    /// The target is the docking place.
    #[export(lasting)]
    docking: Export<Mission>,
    /// Speeds of the base.
    #[actuator]
    base: Actuator<Twist>,
    /// The number of the tag that was followed last; `None` after it awoke.
    followed: Option<u32>,
    sighting: Sighting,
    course: Course,
    effort: Effort,
    /// Sequence number of the last picture or scan.
    last: Option<u64>,
    /// The mark as it was seen last.
    seen: Option<Pose>,
    frozen: Frozen,
    history: OdometryHistory,
    /// Why what was seen last says nothing.
    useless: Option<String>,
    /// The last pose of the odometry.
    last_pose: Option<Pose2D>,
    /// The way since the last sighting, m.
    way: f64,
    /// What it does now, and where the base is in the frame of the mark: x away from the mark, y to the right of one who
    /// faces it, the heading 0 away from the mark.
    step: Option<(Manoeuvre, Pose2D)>,
}

/// A mark as a sensor sees it.
struct Mark {
    pose: Pose,
    /// How ambiguous its direction is, from 0 to 1.
    ambiguity: f64,
}

impl Schema for Dock {
    fn awake(&mut self, cx: &Context) -> Result {
        (self.followed, self.step) = (None, None);
        (self.last_pose, self.useless) = (None, None);
        self.effort = Effort::default();
        Ok(self.expect_one_mark(cx)?)
    }

    fn check(&mut self, cx: &Context) -> Result<Precondition> {
        let id = self.id.get(cx);
        if self.followed.replace(id) != Some(id) {
            self.sighting = Sighting::default();
            self.course = Course::default();
            self.effort = Effort::default();
        }
        self.notice_jump(cx);
        self.look(cx, id);
        let local = self.local(cx);
        self.step = local.map(|local| (self.course.step(&local, &self.goal(cx)), local));
        if self.step.is_some_and(|(step, _)| step == Manoeuvre::There) {
            self.effort = Effort::default();
        }
        self.report(cx);
        let drives = self.step.is_some_and(|(step, _)| step != Manoeuvre::There);
        Ok((drives && self.failure(cx).is_none()).into())
    }

    fn iterate(&mut self, cx: &Context) -> Result {
        let (Some((step, local)), Some(pose)) = (self.step, self.last_pose) else {
            self.base.command(cx, Twist::ZERO);
            return Ok(());
        };
        let goal = self.goal(cx);
        let [speed, turn] = self.course.command(step, &local, &goal);
        let allowance = Duration::from_secs_f64(self.movement_time_allowance.get(cx));
        let failure = self
            .effort
            .command(cx.now(), (step, &local, &pose), &goal, allowance);
        let twist = match failure {
            Some(words) => {
                warn!(cx, "gives up: {words}");
                Twist::ZERO
            }
            None => Twist::planar(speed, turn),
        };
        self.base.command(cx, twist);
        Ok(())
    }
}

impl Inspect for Dock {
    fn inspect(&self, cx: &Context, problems: &mut Problems) {
        problems.expect(&self.id, self.expect_one_mark(cx));
    }
}

impl Dock {
    fn expect_one_mark(&self, cx: &Context) -> Result<(), &'static str> {
        match self.tags.is_bound(cx) == self.reflector.is_bound(cx) {
            true => Err("bind one of the imports `tags` and `reflector`"),
            false => Ok(()),
        }
    }

    /// Returns the odometry, if its numbers are finite.
    fn odometry<'c>(&self, cx: &'c Context) -> Option<Sample<'c, Odometry>> {
        self.pose.get(cx).filter(|pose| is_finite(pose))
    }

    /// Forgets where the mark is when the odometry jumps.
    fn notice_jump(&mut self, cx: &Context) {
        let Some(pose) = self.odometry(cx).map(|odometry| odometry.pose2d()) else {
            return;
        };
        let last = self.last_pose.replace(pose);
        if let Some(last) = &last
            && is_jump(last, &pose, self.jump.get(cx))
        {
            warn!(cx, "{}", jumped(last, &pose));
            self.frozen.jump(last, &pose);
            self.sighting = Sighting::default();
            self.course = Course::default();
            self.effort = Effort::default();
        } else {
            self.way += last.map_or(0.0, |last| last.distance_to(&pose));
        }
    }

    /// Returns the number and the time of the newest picture or scan, and the mark in it.
    fn newest(&self, cx: &Context, id: u32) -> Option<(u64, Duration, Option<Mark>)> {
        if let Some(seen) = self.reflector.get(cx) {
            let mark = Mark {
                pose: seen.pose,
                ambiguity: 0.0,
            };
            return Some((seen.sequence(), seen.time(), Some(mark)));
        }
        let tags = self.tags.get(cx)?;
        let tag = tags.tags.iter().find(|tag| tag.id == id);
        let mark = tag.map(|tag| Mark {
            pose: tag.pose,
            ambiguity: tag.ambiguity,
        });
        Some((tags.sequence(), tags.time(), mark))
    }

    /// Takes the newest sighting of the mark.
    fn look(&mut self, cx: &Context, id: u32) {
        let Some(pose) = self.odometry(cx) else { return };
        self.history.add(pose.time(), &pose);
        let Some((sequence, time, mark)) = self.newest(cx, id) else {
            return;
        };
        if self.last.replace(sequence) == Some(sequence) {
            return;
        }
        let Some(Mark {
            pose: mark,
            ambiguity,
        }) = mark
        else {
            return;
        };
        let last = self.seen.replace(mark);
        let differs = last.is_none_or(|last| last.as_bytes() != mark.as_bytes());
        if self.frozen.is_frozen(differs, &pose.pose2d(), REPEAT_MOTION) {
            self.useless = Some("the sensor repeats its last picture or scan".to_owned());
            return;
        }
        let is_reflector = self.reflector.is_bound(cx);
        // Where the base was when the picture or the scan was taken.
        let sensor = if is_reflector { "scans" } else { "pictures" };
        let base = match self.history.base(sensor, time, cx.now()) {
            Ok(base) => base,
            Err(words) => return self.useless = Some(words),
        };
        self.useless = None;
        let [ahead, left, yaw] = [&self.ahead, &self.left, &self.yaw].map(|part| part.get(cx));
        let seen = if is_reflector {
            Pose2D::new(ahead, left, yaw).transform(&mark.into())
        } else {
            let mount = CameraMount {
                position: [ahead, left, 0.0],
                pan: yaw,
                tilt: self.tilt.get(cx),
            };
            mount.facing(&mark)
        };
        if self.way > DRIFT_WAY {
            self.sighting = Sighting::default();
        }
        if is_reflector && let Some(known) = self.sighting.place(cx.now(), Duration::MAX) {
            let off = known.distance_to(&base.transform(&seen));
            if off > OTHER_DISTANCE {
                self.useless = Some(format!("another reflector, {off:.1} m beside it, is in sight"));
                return;
            }
        }
        self.sighting.add(&base, &seen, ambiguity, time);
        self.way = 0.0;
    }

    /// Returns the pose of the base in the frame of the mark; `None` while that is unknown.
    fn local(&self, cx: &Context) -> Option<Pose2D> {
        let patience = Duration::from_secs_f64(self.patience.get(cx));
        let tag = self.sighting.place(cx.now(), patience)?;
        Some(tag.localize(&self.odometry(cx)?.pose2d()))
    }

    /// Why it gave up the drive.
    fn failure(&mut self, cx: &Context) -> Option<String> {
        let goal = self.goal(cx);
        let failure = self.effort.failure(&self.last_pose?, &goal);
        failure.map(str::to_owned)
    }

    fn goal(&self, cx: &Context) -> approach::Goal {
        approach::Goal {
            leave: self.leave.get(cx).get(),
            distance: self.distance.get(cx),
            off: self.off.get(cx),
            margin: self.margin.get(cx),
            speed: self.speed.get(cx),
            turn: self.turn.get(cx),
            least: (self.min_speed.get(cx), self.min_turn.get(cx)),
            heading: self.yaw_goal_tolerance.get(cx),
        }
    }

    /// Returns what it says while it does not know where the mark is.
    fn waiting(&self, cx: &Context) -> String {
        if self.reflector.is_bound(cx) {
            let words = self.state.get(cx);
            let words = words.as_ref().map(|words| words.as_str());
            // It is said of a reflector that is in sight.
            let useless = self
                .useless
                .as_deref()
                .filter(|_| self.reflector.get(cx).is_some());
            return useless.or(words).unwrap_or("waiting for the reflector").into();
        }
        if self.sighting.is_known() {
            return "the tag is not in sight".into();
        }
        if let Some(useless) = &self.useless {
            return format!("tag {}: {useless}", self.id.get(cx));
        }
        let tags = self.tags.get(cx);
        let others = tags.iter().flat_map(|tags| tags.tags.iter());
        let others: Vec<String> = others.map(|tag| tag.id.to_string()).collect();
        let sees = if others.is_empty() { "" } else { ", it sees " };
        format!("waiting for tag {}{sees}{}", self.id.get(cx), others.join(", "))
    }

    fn report(&mut self, cx: &Context) {
        let mark = if self.reflector.is_bound(cx) {
            "reflector"
        } else {
            "tag"
        };
        let failure = self.failure(cx);
        let (state, note) = match self.step {
            Some((step, _)) if step != Manoeuvre::There && failure.is_some() => {
                (Mission::FAILED, failure.unwrap_or_default())
            }
            None if self.odometry(cx).is_none() => (Mission::RUNNING, "waiting for the odometry".into()),
            None if !self.sighting.is_known() => (Mission::RUNNING, self.waiting(cx)),
            None => (Mission::FAILED, self.waiting(cx)),
            Some((Manoeuvre::There, _)) if self.leave.get(cx).get() => {
                (Mission::DONE, format!("off the {mark}"))
            }
            Some((Manoeuvre::There, _)) => (Mission::DONE, "docked".into()),
            Some((Manoeuvre::Approach, _)) => (Mission::RUNNING, format!("driving to the {mark}")),
            Some((Manoeuvre::Back, _)) => (Mission::RUNNING, "driving back".into()),
            Some((Manoeuvre::Turn, _)) => (Mission::RUNNING, format!("turning toward the {mark}")),
        };
        let place = self.sighting.place(cx.now(), Duration::MAX);
        let target = place
            .map(|place| place.transform(&Pose2D::new(self.distance.get(cx), 0.0, core::f64::consts::PI)));
        let distance = self
            .step
            .map(|(_, local)| libm::hypot(local.x - self.distance.get(cx), local.y));
        self.docking.write(
            cx,
            Mission {
                state,
                reached: (state == Mission::DONE).into(),
                total: 1,
                note: Text::truncated(&note),
                target: target.unwrap_or_default(),
                distance: distance.unwrap_or_default(),
                ..Mission::default()
            },
        );
    }
}

/// Returns the heading relative to the direction toward the mark, rad.
fn astray(local: &Pose2D) -> f64 {
    normalize_angle(local.theta - core::f64::consts::PI)
}

jde_schema::export!(
    "dock",
    "Drives to an AprilTag or a reflector and off again, and finds reflectors.",
    [Dock, Reflector]
);

#[cfg(test)]
mod tests;
