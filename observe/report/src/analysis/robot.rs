//! One robot of a recording: its path with the acting schemas, its laser scans, and its ground truth. It
//! knows no other robot and no world.

use jde_core::Nanos;
use jde_log::{DecodeError, Message};
use jde_sim::Footprint;
use jde_types::{Body, LaserPoint, LaserScan, Odometry, Pose2D, Truth};

use super::columns::Columns;
use super::decimated::Decimated;
use super::drive::Reading;
use crate::map::{PathPoint, is_placed};

/// Most points stored of all paths, and most scans: more than a picture can show.
pub(super) const MAX_POINTS: usize = 40_000;
const MOST_SCANS: usize = 2000;
/// Least time between two scans that are read, ns: one scan a second is enough to show a building.
const SCAN: Nanos = 1_000_000_000;

/// The topics and the path of one robot.
pub(super) struct Robot {
    pub(super) name: String,
    pub(super) truth_topic: Option<String>,
    pub(super) odometry_topic: Option<String>,
    pub(super) laser_topic: Option<String>,
    pub(super) body_topic: Option<String>,
    pub(super) body: Option<Body>,
    pub(super) truth: Option<TruthRange>,
    pub(super) odometry: Option<Pose2D>,
    pub(super) pose: Option<Pose2D>,
    /// The robot's first known place, in the frame of the ground truth and in that of the odometry.
    pub(super) anchor: Option<(Pose2D, Pose2D)>,
    pub(super) path: Decimated<PathPoint>,
    /// The driven distance, m, not decimated; and the last valid place.
    pub(super) distance: f64,
    pub(super) place: Option<Pose2D>,
    pub(super) scans: Decimated<Vec<(f64, f64)>>,
    pub(super) scanned: Option<Nanos>,
}

/// Ground truth of a robot. Its counts begin at the start of the robot.
pub(super) struct TruthRange {
    /// The last one before the reported time; none if the application started within it.
    pub(super) before: Option<Truth>,
    pub(super) last: Truth,
}

impl Robot {
    /// One of `count` robots, which share the limits of storage.
    pub(super) fn new(name: &str, count: usize) -> Self {
        Self {
            name: name.to_owned(),
            truth_topic: None,
            odometry_topic: None,
            laser_topic: None,
            body_topic: None,
            body: None,
            truth: None,
            odometry: None,
            pose: None,
            anchor: None,
            path: Decimated::new((MAX_POINTS / count).max(2)),
            distance: 0.0,
            place: None,
            scans: Decimated::new((MOST_SCANS / count).max(2)),
            scanned: None,
        }
    }

    pub(super) fn has(&self, topic: &str) -> bool {
        let topics = [
            &self.truth_topic,
            &self.odometry_topic,
            &self.laser_topic,
            &self.body_topic,
        ];
        topics.into_iter().flatten().any(|own| own == topic)
    }

    pub(super) fn message(
        &mut self,
        columns: Columns,
        time: Nanos,
        reading: &mut Reading<'_>,
        shows_walls: bool,
        acting: impl Fn(&str) -> Option<usize>,
    ) -> Result<(), DecodeError> {
        let message = reading.message;
        let topic = Some(&message.channel.topic);
        if self.truth_topic.as_ref() == topic {
            if let Some(truth) = reading.read::<Truth>()? {
                self.add_truth(columns, time, message, truth);
                self.at(columns, time, truth.pose, acting);
            }
        } else if self.odometry_topic.as_ref() == topic {
            if let Some(odometry) = reading.read::<Odometry>()? {
                self.odometry = Some(odometry.pose2d());
                if self.truth_topic.is_none() {
                    self.at(columns, time, odometry.pose2d(), acting);
                }
            }
        } else if self.body_topic.as_ref() == topic {
            self.body = reading.read::<Body>()?;
        } else if !shows_walls {
            self.laser(columns, time, reading)?;
        }
        if let (None, Some(truth), Some(odometry)) = (self.anchor, self.pose, self.odometry)
            && self.truth_topic.is_some()
        {
            self.anchor = Some((truth, odometry));
        }
        Ok(())
    }

    fn add_truth(&mut self, columns: Columns, time: Nanos, message: &Message, truth: Truth) {
        let range = self.truth.get_or_insert_with(|| TruthRange {
            // Only the first value of all has nothing before it.
            before: (message.sequence > 1).then_some(truth),
            last: truth,
        });
        range.last = truth;
        if time < columns.from {
            range.before = Some(truth);
        }
    }

    pub(super) fn at(
        &mut self,
        columns: Columns,
        time: Nanos,
        pose: Pose2D,
        acting: impl Fn(&str) -> Option<usize>,
    ) {
        self.pose = Some(pose);
        if columns.has(time) {
            // An invalid pose is not drawn and adds no distance.
            if is_placed(&[pose.x, pose.y]) {
                let previous = self.place.replace(pose).unwrap_or(pose);
                self.distance += (pose.x - previous.x).hypot(pose.y - previous.y);
            }
            self.path.add(PathPoint {
                time: time as f64 / 1e9,
                x: pose.x,
                y: pose.y,
                heading: pose.theta,
                winner: acting(&self.name),
            });
        }
    }

    fn laser(&mut self, columns: Columns, time: Nanos, reading: &mut Reading<'_>) -> Result<(), DecodeError> {
        let is_due = self.scanned.is_none_or(|last| time >= last.saturating_add(SCAN));
        let (true, true, Some(robot)) = (is_due, columns.has(time), self.pose) else {
            return Ok(());
        };
        let Some(scan) = reading.read::<LaserScan>()? else {
            return Ok(());
        };
        self.scanned = Some(time);
        let frame = scan.header.frame_id.as_str();
        let laser = robot.transform(&self.body.map_or(Pose2D::ORIGIN, |body| body.laser(frame)));
        let place = |point: LaserPoint| {
            let place = laser.transform(&Pose2D::new(point.x, point.y, 0.0));
            (place.x, place.y)
        };
        self.scans.add(scan.points().map(place).collect());
        Ok(())
    }
}

/// The outline of a body; none if it is unknown or not that of a robot.
pub(super) fn footprint(body: &Body) -> Option<Footprint> {
    let corners: Vec<_> = body
        .footprint
        .points
        .iter()
        .map(|point| [point.x, point.y])
        .collect();
    let radius = body.footprint.radius;
    if corners.is_empty() {
        (radius.is_finite() && radius > 0.0).then_some(Footprint::Circle { radius })
    } else {
        Footprint::polygon(&corners).ok()
    }
}

impl TruthRange {
    pub(super) fn collisions(&self) -> u64 {
        let before = self.before.map_or(0, |before| before.collisions);
        self.last.collisions.saturating_sub(before)
    }

    pub(super) fn min_clearance(&self) -> Option<f64> {
        let least = self.last.min_clearance;
        let in_range = self.before.is_none_or(|before| least < before.min_clearance);
        (in_range && least.is_finite()).then_some(least)
    }
}
