//! The schema of localization by tags: where they are, what was seen of them, and when the pose is sure.

mod filter;
mod panel;

use jde_motion::{Frozen, OdometryHistory, is_jump, jumped};
use jde_schema::prelude::*;
use jde_schema::types::{TagDetection, TagDetections};
use jde_vision::CameraMount;

use crate::ports::{LocalizedPose, PoseLimits};

use filter::{Errors, Estimate, Seen};

/// A motion after which tags that are the same to the bit are no new ones, m and rad: no camera sees the same twice.
const REPEAT_MOTION: f64 = 0.001;
/// The least part of a direction's weight that an ambiguity leaves.
const AMBIGUOUS_WEIGHT: f64 = 0.02;
/// How many sightings in a row that do not fit mean that the robot is elsewhere.
const MISFITS: u32 = 10;

/// Where a tag is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Value)]
#[repr(C)]
#[value(name = "jde_msgs/msg/TagPlace")]
pub struct TagPlace {
    /// The number of the tag.
    pub id: u64,
    /// Its middle, and the direction in which it faces, in the frame of the map.
    pub pose: Pose2D,
}

/// Where tags are.
#[derive(Clone, Copy, Debug, Default, PartialEq, Value)]
#[repr(C)]
#[value(name = "jde_msgs/msg/TagPlaces")]
pub struct TagPlaces {
    /// The tags, each number once.
    pub tags: Seq<TagPlace, 64>,
}

/// Exports where the robot is on a map, by tags whose places are known: an extended Kalman filter.
///
/// The odometry moves the pose, and each tag that a camera sees corrects it, and with it the systematic errors of the
/// odometry; a sighting that does not fit is left out. The first tag says where the robot is. The pose is exported while
/// it is sure, and retracted otherwise; `state` says why.
#[derive(Describe)]
#[schema(perceptive, period = "50ms", budget = "10ms")]
pub struct Tags {
    /// The tags that a camera of the robot sees, from `tags`.
    #[import]
    tags: Import<TagDetections>,
    /// The pose and velocity by the odometry.
    #[import]
    odometry: Import<Odometry>,
    /// Where the tags are in the frame of the map: `{ tags = [[7, [5.0, 2.0, "180 deg"]]] }`.
    #[modulation(default = TagPlaces { tags: Seq::new() })]
    places: Modulation<TagPlaces>,
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
    /// Standard deviation of the range of a tag at 1 m; that of other ranges grows with their square.
    #[modulation(default = 0.01, unit = "m", min = 0.0001)]
    range_deviation: Modulation<f64>,
    /// Standard deviation of the bearing of a tag.
    #[modulation(default = 0.01, unit = "rad", min = 0.0001)]
    bearing_deviation: Modulation<f64>,
    /// Standard deviation of the direction in which a tag at 1 m faces; it grows with the square of the range.
    #[modulation(default = 0.04, unit = "rad", min = 0.0001)]
    facing_deviation: Modulation<f64>,
    /// Standard deviation of the heading of the odometry after a turn by 1 rad; like the others, it grows with the root.
    #[modulation(default = 0.05, unit = "rad", min = 0.0, max = 10.0, was = "turn_by_turn")]
    rotation_noise_from_rotation: Modulation<f64>,
    /// Standard deviation of the heading of the odometry after 1 m.
    #[modulation(default = 0.03, unit = "rad", min = 0.0, max = 10.0, was = "turn_by_way")]
    rotation_noise_from_translation: Modulation<f64>,
    /// Standard deviation of the way of the odometry after 1 m.
    #[modulation(default = 0.05, unit = "m", min = 0.0, max = 10.0, was = "way_by_way")]
    translation_noise_from_translation: Modulation<f64>,
    /// Standard deviation of the share by which ways and turns of the odometry are too short or too long. The share is
    /// estimated.
    #[modulation(default = 0.01, min = 0.0, max = 1.0)]
    scale_deviation: Modulation<f64>,
    /// Standard deviation of the turn that the odometry misses for each metre, because one wheel is larger than the
    /// other. The turn is estimated.
    #[modulation(default = 0.05, unit = "rad/m", min = 0.0, max = 10.0)]
    drift_deviation: Modulation<f64>,
    #[ports]
    limits: PoseLimits,
    #[ports]
    place: LocalizedPose,
    estimate: Option<Estimate>,
    /// The last pose of the odometry.
    last: Option<Pose2D>,
    /// What was known of the errors of the odometry when the last estimate ended.
    errors: Option<Errors>,
    /// Sequence number of the last detections.
    seen: Option<u64>,
    /// The last tags.
    last_tags: Seq<TagDetection, 32>,
    frozen: Frozen,
    /// Why the last picture says nothing.
    late: Option<String>,
    history: OdometryHistory,
    /// Sightings in a row that did not fit.
    misfits: u32,
    /// The words of the last iteration.
    words: String,
}

impl Schema for Tags {
    fn awake(&mut self, _: &Context) -> Result {
        // What happened while it slept is not known.
        self.forget();
        (self.last, self.late, self.misfits) = (None, None, 0);
        Ok(())
    }

    fn sleep(&mut self, cx: &Context) {
        self.place.pose.retract(cx);
        self.place.correction.retract(cx);
        self.place.state.retract(cx);
    }

    fn iterate(&mut self, cx: &Context) -> Result {
        self.words = match self.localize(cx) {
            Ok(words) => words,
            Err(words) => {
                self.place.pose.retract(cx);
                self.place.correction.retract(cx);
                words
            }
        };
        self.place.state.write(cx, Text::truncated(&self.words));
        Ok(())
    }
}

impl Inspect for Tags {
    fn inspect(&self, cx: &Context, problems: &mut Problems) {
        let places = self.places.get(cx);
        let ids: Vec<u64> = places.tags.iter().map(|tag| tag.id).collect();
        if ids.is_empty() {
            problems.wrong(
                &self.places,
                "states no tag: expected { tags = [[7, [5.0, 2.0, \"180 deg\"]]] }",
            );
        }
        if let Some((_, twice)) = ids
            .iter()
            .enumerate()
            .find(|(index, id)| ids[..*index].contains(id))
        {
            problems.wrong(&self.places, format!("states tag {twice} twice: drop one"));
        }
    }
}

impl Tags {
    /// Exports the pose.
    ///
    /// # Errors
    /// Why there is none.
    fn localize(&mut self, cx: &Context) -> Result<String, String> {
        let odometry = self.odometry.get(cx).ok_or("there is no odometry")?;
        let measured = odometry.pose2d();
        if let Some(last) = self.last.replace(measured) {
            self.advance(cx, &last, &measured);
        }
        self.look(cx, &odometry);
        let estimate = self.estimate.ok_or_else(|| match &self.late {
            Some(late) => format!("no tag was seen yet: {late}"),
            None => "no tag was seen yet".into(),
        })?;
        let [deviation, heading] = estimate.deviations();
        let words = format!("{deviation:.2} m and {:.1} degrees", heading.to_degrees());
        let is_sure = deviation <= self.limits.sure_deviation.get(cx)
            && heading <= self.limits.sure_heading_deviation.get(cx);
        if !is_sure {
            return Err(format!("not sure: it may be off by {words}"));
        }
        let header = Header {
            stamp: odometry.header.stamp,
            frame_id: Text::new("map"),
        };
        let [x, y, heading, ..] = estimate.covariance;
        let covariance = [x, y, heading].map(|[x, y, heading, ..]| [x, y, heading]);
        let exported = Odometry {
            header,
            pose: PoseWithCovariance::planar(estimate.pose, &covariance),
            ..*odometry
        };
        self.place.pose.write_at(cx, exported, odometry.time());
        let correction = estimate.pose.transform(&measured.localize(&Pose2D::ORIGIN));
        self.place.correction.write_at(
            cx,
            PoseStamped {
                header,
                pose: correction.into(),
            },
            odometry.time(),
        );
        Ok(format!("sure to {words}"))
    }

    /// Moves the pose by a step of the odometry; a jump says nothing about where the robot is.
    fn advance(&mut self, cx: &Context, from: &Pose2D, to: &Pose2D) {
        if is_jump(from, to, self.limits.jump.get(cx)) {
            warn!(cx, "{}", jumped(from, to));
            self.frozen.jump(from, to);
            self.forget();
            return;
        }
        let step = from.localize(to);
        let way = libm::hypot(step.x, step.y);
        let turn = (self.rotation_noise_from_rotation.get(cx).powi(2) * step.theta.abs()
            + self.rotation_noise_from_translation.get(cx).powi(2) * way)
            .sqrt();
        if let Some(estimate) = &mut self.estimate {
            estimate.advance(
                &step,
                [self.translation_noise_from_translation.get(cx) * way.sqrt(), turn],
            );
        }
    }

    /// Forgets where the robot is, but not what it knows of the wheels.
    fn forget(&mut self) {
        let errors = self.estimate.take().map(|estimate| estimate.errors());
        self.errors = errors.or(self.errors);
    }

    /// Takes what is new of the tags.
    fn look(&mut self, cx: &Context, odometry: &Sample<'_, Odometry>) {
        self.history.add(odometry.time(), odometry);
        let Some(tags) = self.tags.get(cx) else { return };
        if self.seen.replace(tags.sequence()) == Some(tags.sequence()) {
            return;
        }
        let differs = !bytes(&tags.tags).eq(bytes(&self.last_tags));
        self.last_tags = tags.tags;
        if self.frozen.is_frozen(differs, &odometry.pose2d(), REPEAT_MOTION) {
            return;
        }
        // Where the base was when the picture was taken, as the base sees it now.
        let base = self.history.base("pictures", tags.time(), cx.now());
        let then = base.map(|base| odometry.pose2d().localize(&base));
        let then = match then {
            Ok(then) => then,
            Err(words) => return self.late = Some(words),
        };
        self.late = None;
        let places = self.places.get(cx);
        for tag in tags.tags.iter() {
            let Some(place) = places.tags.iter().find(|place| place.id == u64::from(tag.id)) else {
                continue;
            };
            let seen = self.seen(cx, &then, tag);
            if !seen.is_finite() {
                continue;
            }
            let fits = self
                .estimate
                .as_mut()
                .is_some_and(|estimate| estimate.correct(&place.pose, &seen));
            self.misfits = if fits { 0 } else { self.misfits + 1 };
            if self.estimate.is_none() || self.misfits >= MISFITS {
                let prior = [self.scale_deviation.get(cx), self.drift_deviation.get(cx)];
                let errors = self.errors.take().unwrap_or_else(|| Errors::new(prior));
                self.estimate = Some(Estimate::from(&place.pose, &seen, &errors));
                self.misfits = 0;
            }
        }
    }

    /// Returns where a tag is, as a base sees it that was at `then` when the picture was taken.
    fn seen(&self, cx: &Context, then: &Pose2D, tag: &TagDetection) -> Seen {
        let mount = CameraMount {
            position: [self.ahead.get(cx), self.left.get(cx), 0.0],
            pan: self.yaw.get(cx),
            tilt: self.tilt.get(cx),
        };
        let pose = then.transform(&mount.facing(&tag.pose));
        let square = pose.x * pose.x + pose.y * pose.y;
        // An ambiguous direction may be any: straight before a tag, all are ambiguous.
        let clear = (1.0 - tag.ambiguity).max(AMBIGUOUS_WEIGHT);
        let [range, facing] = [&self.range_deviation, &self.facing_deviation]
            .map(|deviation| deviation.get(cx) * square.max(0.1));
        Seen {
            pose,
            deviations: [range, self.bearing_deviation.get(cx), facing / clear],
        }
    }
}

fn bytes(tags: &Seq<TagDetection, 32>) -> impl Iterator<Item = &[u8]> {
    tags.iter().map(Value::as_bytes)
}

#[cfg(test)]
mod tests;
