//! One robot of a run: its pose, its path with the acting schemas, its laser scans, and its ground truth. It knows no other
//! robot and no world.

use jde_core::Nanos;
use jde_types::{Body, LaserPoint, LaserScan, Odometry, Pose2D, Truth};

use crate::decimated::Decimated;
use crate::robot_sources::RobotSources;

/// Least time between two scans that are kept, ns: one scan a second is enough to show a building.
const SCAN_INTERVAL: Nanos = 1_000_000_000;
/// Places beyond 1000 km are measurement errors.
const FARTHEST_PLACE: f64 = 1e6;

/// A robot at one time. The winner remains until the next point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PathPoint {
    /// Seconds since the start.
    pub time: f64,
    /// Metres.
    pub x: f64,
    /// Metres.
    pub y: f64,
    /// Radians.
    pub heading: f64,
    /// The schema that acts.
    pub winner: Option<usize>,
}

/// What happened to a robot. Its frame is the world where there is ground truth, or else that of its odometry.
#[derive(Clone, Debug)]
pub struct RobotTimeline {
    /// Its name, and where its values come from.
    pub sources: RobotSources,
    /// Its body, if it is known.
    pub body: Option<Body>,
    truth: Option<TruthRange>,
    /// When the first contact began in the time that counts, as far as is known.
    pub first_contact: Option<Nanos>,
    /// Its pose by odometry.
    pub odometry: Option<Pose2D>,
    /// Its pose, in the frame of its path.
    pub pose: Option<Pose2D>,
    /// Its first known place, in the frame of the ground truth and in that of the odometry.
    anchor: Option<(Pose2D, Pose2D)>,
    begin: Nanos,
    path: Decimated<PathPoint>,
    /// The driven distance, m, of all points of the path.
    pub distance: f64,
    /// The last valid place.
    place: Option<Pose2D>,
    scans: Decimated<Vec<(f64, f64)>>,
    scanned: Option<Nanos>,
}

/// Ground truth of a robot. Its counts begin at the start of the robot.
#[derive(Clone, Copy, Debug)]
struct TruthRange {
    /// The last one before the time that counts; `None` if the robot started within it.
    before: Option<Truth>,
    last: Truth,
}

impl RobotTimeline {
    /// Creates a robot of which nothing is known. What is earlier than `begin` is no part of its path. At most so many points
    /// and scans are kept.
    #[must_use]
    pub(crate) fn new(sources: RobotSources, begin: Nanos, most_points: usize, most_scans: usize) -> Self {
        Self {
            sources,
            body: None,
            truth: None,
            first_contact: None,
            odometry: None,
            pose: None,
            anchor: None,
            begin,
            path: Decimated::new(most_points),
            distance: 0.0,
            place: None,
            scans: Decimated::new(most_scans),
            scanned: None,
        }
    }

    /// Adds ground truth. `is_first` is whether the robot has just started; `acting` returns the schema that acts for it.
    pub fn add_truth(
        &mut self,
        time: Nanos,
        truth: Truth,
        is_first: bool,
        acting: impl FnOnce() -> Option<usize>,
    ) {
        let range = self.truth.get_or_insert(TruthRange {
            before: (!is_first).then_some(truth),
            last: truth,
        });
        range.last = truth;
        if time < self.begin {
            range.before = Some(truth);
        }
        if self.first_contact.is_none() && self.collisions() > Some(0) {
            self.first_contact = Some(time);
        }
        self.add_pose(time, truth.pose, acting);
        self.set_anchor();
    }

    /// Adds odometry, which gives the path if there is no ground truth.
    pub fn add_odometry(&mut self, time: Nanos, odometry: &Odometry, acting: impl FnOnce() -> Option<usize>) {
        let pose = odometry.pose2d();
        self.odometry = Some(pose);
        if self.sources.truth.is_none() {
            self.add_pose(time, pose, acting);
        }
        self.set_anchor();
    }

    /// Whether a scan at a time would be kept.
    #[must_use]
    pub fn wants_scan(&self, time: Nanos) -> bool {
        let is_due = self
            .scanned
            .is_none_or(|last| time >= last.saturating_add(SCAN_INTERVAL));
        is_due && time >= self.begin && self.pose.is_some()
    }

    /// Adds a scan of its laser, if it is [wanted](Self::wants_scan).
    pub fn add_scan(&mut self, time: Nanos, scan: &LaserScan) {
        let Some(robot) = self.pose.filter(|_| self.wants_scan(time)) else {
            return;
        };
        self.scanned = Some(time);
        let frame = scan.header.frame_id.as_str();
        let laser = robot.transform(&self.body.map_or(Pose2D::ORIGIN, |body| body.laser(frame)));
        let place = |point: LaserPoint| {
            let place = laser.transform(&Pose2D::new(point.x, point.y, 0.0));
            (place.x, place.y)
        };
        self.scans.add(scan.points().map(place).collect());
    }

    /// Returns its contacts; `None` without ground truth.
    #[must_use]
    pub fn collisions(&self) -> Option<u64> {
        let truth = self.truth.as_ref()?;
        let before = truth.before.map_or(0, |before| before.collisions);
        Some(truth.last.collisions.saturating_sub(before))
    }

    /// Returns the ground truth that is newest.
    #[must_use]
    pub fn truth(&self) -> Option<&Truth> {
        self.truth.as_ref().map(|truth| &truth.last)
    }

    /// Returns the least distance to an obstacle, m; `None` without ground truth, or if it occurred before the time that
    /// counts.
    #[must_use]
    pub fn min_clearance(&self) -> Option<f64> {
        let truth = self.truth.as_ref()?;
        let least = truth.last.min_clearance;
        let is_new = truth.before.is_none_or(|before| least < before.min_clearance);
        (is_new && least.is_finite()).then_some(least)
    }

    /// Returns the number of points for each one that is kept.
    #[must_use]
    pub fn path_step(&self) -> u64 {
        self.path.step()
    }

    /// Returns the path.
    #[must_use]
    pub fn path(&self) -> &[PathPoint] {
        self.path.items()
    }

    /// Returns the path, and the ends of laser beams.
    #[must_use]
    pub fn into_path(self) -> (Vec<PathPoint>, Vec<(f64, f64)>) {
        let scans = self.scans.into_items().into_iter().flatten();
        (self.path.into_items(), scans.collect())
    }

    /// Converts a position from the frame of the odometry to that of the path.
    #[must_use]
    pub fn to_path_frame(&self, (x, y): (f64, f64)) -> (f64, f64) {
        let Some((truth, odometry)) = &self.anchor else {
            return (x, y);
        };
        let place = truth.transform(&odometry.localize(&Pose2D::new(x, y, 0.0)));
        (place.x, place.y)
    }

    fn add_pose(&mut self, time: Nanos, pose: Pose2D, acting: impl FnOnce() -> Option<usize>) {
        self.pose = Some(pose);
        if time < self.begin {
            return;
        }
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
            winner: acting(),
        });
    }

    fn set_anchor(&mut self) {
        if let (None, Some(truth), Some(odometry)) = (&self.anchor, &self.truth, self.odometry) {
            self.anchor = Some((truth.last.pose, odometry));
        }
    }
}

/// Whether numbers can be coordinates of a place.
#[must_use]
pub fn is_placed(numbers: &[f64]) -> bool {
    numbers.iter().all(|number| number.abs() <= FARTHEST_PLACE)
}
