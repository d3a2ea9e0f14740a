//! Docking at an AprilTag. The schema avoids no obstacles: another one must brake.

mod approach;
mod panel;
mod sighting;

use jde_motion::{Frozen, arc, check_time, is_finite, is_jump, jumped};
use jde_schema::prelude::*;
use jde_schema::types::{TagDetection, TagDetections, normalize_angle};
use jde_vision::CameraMount;

use approach::{Course, Step};
use sighting::Sighting;

/// A motion after which a tag that is the same to the bit is not seen, m and rad: no camera sees the same twice.
const UNCHANGED: f64 = 0.001;

/// Drives a base to a place straight before a tag, heading toward it, and off again.
///
/// It follows the line on which the tag faces, more slowly as it comes nearer, stops, and turns toward the tag. If it
/// is too near, or near but beside the line, it drives back and begins anew. What it saw of the tag is kept in the
/// frame of the odometry, so the tag may leave the picture for `patience`. The base must be able to turn on the spot.
///
/// READY while the tag was seen and the base is not where it shall be.
#[derive(Describe)]
#[schema(motor, period = "50ms", budget = "10ms")]
pub struct Dock {
    /// The tags that a camera of the base sees, from `tags`.
    #[import]
    tags: Import<TagDetections>,
    /// The measured pose of the base.
    #[import(trigger)]
    pose: Import<Odometry>,
    /// The number of the tag.
    #[modulation(default = 0)]
    id: Modulation<u32>,
    /// Whether it drives off instead: straight back, as far as `off`.
    #[modulation(default = Flag::FALSE)]
    leave: Modulation<Flag>,
    /// Distance from the tag to the middle of the base where it docks.
    #[modulation(default = 0.5, unit = "m", min = 0.05)]
    distance: Modulation<f64>,
    /// Distance from the tag at which it has left.
    #[modulation(default = 1.5, unit = "m", min = 0.1)]
    off: Modulation<f64>,
    /// How far it must be off the place where it shall be, to begin anew. It also does if it is turned by 2 degrees.
    #[modulation(default = 0.05, unit = "m", min = 0.015)]
    margin: Modulation<f64>,
    /// How far the camera is ahead of the base.
    #[modulation(default = 0.0, unit = "m")]
    ahead: Modulation<f64>,
    /// How far the camera is to the left of the base.
    #[modulation(default = 0.0, unit = "m")]
    left: Modulation<f64>,
    /// How far the camera is turned to the left.
    #[modulation(default = 0.0, unit = "rad")]
    yaw: Modulation<f64>,
    /// How far the camera looks down.
    #[modulation(default = 0.0, unit = "rad")]
    tilt: Modulation<f64>,
    /// Highest speed.
    #[modulation(default = 0.2, unit = "m/s", min = 0.01)]
    speed: Modulation<f64>,
    /// Highest turn rate.
    #[modulation(default = 0.8, unit = "rad/s", min = 0.01)]
    turn: Modulation<f64>,
    /// How long the tag may be out of sight.
    #[modulation(default = 10.0, unit = "s", min = 0.1, max = 3600.0)]
    patience: Modulation<f64>,
    /// A step of the odometry from which on it is a jump, and no motion. So is a turn by more than 90 degrees.
    #[modulation(default = 0.3, unit = "m", min = 0.1)]
    jump: Modulation<f64>,
    /// DONE while the base is where it shall be, FAILED while a tag that was seen is out of sight for too long, else
    /// RUNNING; the note says what it does. The target is the docking place.
    #[export]
    docking: Export<Mission>,
    /// Speeds of the base.
    #[actuator]
    base: Actuator<Twist>,
    /// The number of the tag that was followed last; `None` after it awoke.
    followed: Option<u32>,
    sighting: Sighting,
    course: Course,
    /// Sequence number of the last detections.
    last: Option<u64>,
    /// The tag as it was seen last.
    seen: Option<TagDetection>,
    frozen: Frozen,
    /// Why the last picture of the tag says nothing.
    late: Option<String>,
    /// The last pose of the odometry.
    last_pose: Option<Pose2D>,
    /// What it does now, and where the base is in the frame of the tag: x away from the tag, y to the right of one who
    /// faces it, the heading 0 away from the tag.
    state: Option<(Step, Pose2D)>,
}

impl Schema for Dock {
    fn awake(&mut self, _: &Context) -> Result {
        (self.followed, self.state) = (None, None);
        (self.last_pose, self.late) = (None, None);
        Ok(())
    }

    fn check(&mut self, cx: &Context) -> Result<Precondition> {
        let id = self.id.get(cx);
        if self.followed.replace(id) != Some(id) {
            self.sighting = Sighting::default();
            self.course = Course::default();
        }
        self.notice_jump(cx);
        self.look(cx, id);
        let local = self.local(cx);
        self.state = local.map(|local| (self.course.step(&local, &self.goal(cx)), local));
        self.report(cx);
        Ok(match self.state {
            None => Precondition::from(false),
            Some((step, _)) => (step != Step::There).into(),
        })
    }

    fn iterate(&mut self, cx: &Context) -> Result {
        let twist = self.state.map_or(Twist::ZERO, |(step, local)| {
            let [speed, turn] = self.course.command(step, &local, &self.goal(cx));
            Twist::planar(speed, turn)
        });
        self.base.command(cx, twist);
        Ok(())
    }
}

impl Dock {
    /// Returns the odometry, if its numbers are finite.
    fn odometry<'c>(&self, cx: &'c Context) -> Option<Sample<'c, Odometry>> {
        self.pose.get(cx).filter(|pose| is_finite(pose))
    }

    /// Forgets where the tag is when the odometry jumps.
    fn notice_jump(&mut self, cx: &Context) {
        let Some(pose) = self.odometry(cx).map(|odometry| odometry.pose2d()) else {
            return;
        };
        if let Some(last) = self.last_pose.replace(pose)
            && is_jump(&last, &pose, self.jump.get(cx))
        {
            warn!(cx, "{}", jumped(&last, &pose));
            self.frozen.jump(&last, &pose);
            self.sighting = Sighting::default();
            self.course = Course::default();
        }
    }

    /// Takes the newest sighting of the tag.
    fn look(&mut self, cx: &Context, id: u32) {
        let (Some(tags), Some(pose)) = (self.tags.get(cx), self.odometry(cx)) else {
            return;
        };
        if self.last.replace(tags.sequence()) == Some(tags.sequence()) {
            return;
        }
        let Some(tag) = tags.tags.iter().find(|tag| tag.id == id) else {
            return;
        };
        let last = self.seen.replace(*tag);
        let differs = last.is_none_or(|last| last.as_bytes() != tag.as_bytes());
        if self.frozen.is_frozen(differs, &pose.pose2d(), UNCHANGED) {
            return;
        }
        // Where the base was when the picture was taken.
        let since = tags.time().as_secs_f64() - pose.time().as_secs_f64();
        self.late = check_time(since).err();
        if self.late.is_some() {
            return;
        }
        let motion = arc(&pose.twist.twist, since);
        let base = pose.pose2d().transform(&motion);
        let mount = CameraMount {
            position: [self.ahead.get(cx), self.left.get(cx), 0.0],
            pan: self.yaw.get(cx),
            tilt: self.tilt.get(cx),
        };
        let seen = mount.facing(&tag.pose);
        self.sighting.add(&base, &seen, tag.ambiguity, tags.time());
    }

    /// Returns the pose of the base in the frame of the tag; `None` while that is unknown.
    fn local(&self, cx: &Context) -> Option<Pose2D> {
        let patience = Duration::from_secs_f64(self.patience.get(cx));
        let tag = self.sighting.place(cx.now(), patience)?;
        Some(tag.localize(&self.odometry(cx)?.pose2d()))
    }

    fn goal(&self, cx: &Context) -> approach::Goal {
        approach::Goal {
            leave: self.leave.get(cx).get(),
            distance: self.distance.get(cx),
            off: self.off.get(cx),
            margin: self.margin.get(cx),
            speed: self.speed.get(cx),
            turn: self.turn.get(cx),
        }
    }

    /// Returns what it says before it has seen its tag.
    fn waiting(&self, cx: &Context) -> String {
        if let Some(late) = &self.late {
            return format!("tag {}: {late}", self.id.get(cx));
        }
        let tags = self.tags.get(cx);
        let others = tags.iter().flat_map(|tags| tags.tags.iter());
        let others: Vec<String> = others.map(|tag| tag.id.to_string()).collect();
        let sees = if others.is_empty() { "" } else { ", it sees " };
        format!("waiting for tag {}{sees}{}", self.id.get(cx), others.join(", "))
    }

    fn report(&mut self, cx: &Context) {
        let waiting;
        let (state, note) = match self.state {
            None if self.odometry(cx).is_none() => (Mission::RUNNING, "waiting for the odometry"),
            None if !self.sighting.is_known() => {
                waiting = self.waiting(cx);
                (Mission::RUNNING, waiting.as_str())
            }
            None => (Mission::FAILED, "the tag is not in sight"),
            Some((Step::There, _)) if self.leave.get(cx).get() => (Mission::DONE, "off the tag"),
            Some((Step::There, _)) => (Mission::DONE, "docked"),
            Some((Step::Approach, _)) => (Mission::RUNNING, "driving to the tag"),
            Some((Step::Back, _)) => (Mission::RUNNING, "driving back"),
            Some((Step::Turn, _)) => (Mission::RUNNING, "turning toward the tag"),
        };
        let tag = self.sighting.place(cx.now(), Duration::MAX);
        let target =
            tag.map(|tag| tag.transform(&Pose2D::new(self.distance.get(cx), 0.0, core::f64::consts::PI)));
        let distance = self
            .state
            .map(|(_, local)| (local.x - self.distance.get(cx)).hypot(local.y));
        self.docking.write(
            cx,
            Mission {
                state,
                reached: (state == Mission::DONE).into(),
                total: 1,
                note: Text::truncated(note),
                target: target.unwrap_or_default(),
                distance: distance.unwrap_or_default(),
                ..Mission::default()
            },
        );
    }
}

/// Returns the heading relative to the direction toward the tag, rad.
fn astray(local: &Pose2D) -> f64 {
    normalize_angle(local.theta - core::f64::consts::PI)
}

jde_schema::export!("dock", "Drives to an AprilTag and off again.", [Dock]);

#[cfg(test)]
mod tests;
