//! The geometry of pure pursuit: where the robot is along a path, and the arc to a point further on. Pure
//! formulas; a path of a single point is a place to go to.

use jde_schema::types::Pose2D;

/// How far along the path the nearest point may be from the last one, m. A path that crosses itself is
/// then followed in its order.
const WINDOW: f64 = 1.5;

/// A path with the way along it.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Track {
    poses: Vec<Pose2D>,
    /// Way from the start to each pose, m.
    ways: Vec<f64>,
}

impl Track {
    /// Returns a track; `None` without poses, or with one that is not a number.
    pub(super) fn new(poses: impl Iterator<Item = Pose2D>) -> Option<Self> {
        let mut track = Self::default();
        for pose in poses {
            if ![pose.x, pose.y, pose.theta]
                .iter()
                .all(|number| number.is_finite())
            {
                return None;
            }
            let way = match (track.poses.last(), track.ways.last()) {
                (Some(last), Some(way)) => way + last.distance_to(&pose),
                _ => 0.0,
            };
            track.poses.push(pose);
            track.ways.push(way);
        }
        (!track.poses.is_empty()).then_some(track)
    }

    /// The last pose.
    pub(super) fn goal(&self) -> Pose2D {
        self.poses.last().copied().unwrap_or_default()
    }

    /// The way from the start to the goal, m.
    pub(super) fn length(&self) -> f64 {
        self.ways.last().copied().unwrap_or_default()
    }

    /// The way to the point nearest to `pose`, m, not before `progress` and not far beyond it; with no
    /// progress, the first such point of the whole path.
    pub(super) fn nearest(&self, pose: &Pose2D, progress: Option<f64>) -> f64 {
        let (low, high) = match progress {
            Some(progress) => (progress, progress + WINDOW),
            None => (0.0, f64::INFINITY),
        };
        let mut best = (f64::INFINITY, low);
        for (poses, ways) in self.poses.windows(2).zip(self.ways.windows(2)) {
            let length = ways[1] - ways[0];
            if length == 0.0 || ways[1] < low || ways[0] > high {
                continue;
            }
            let (dx, dy) = (
                (poses[1].x - poses[0].x) / length,
                (poses[1].y - poses[0].y) / length,
            );
            let along = (pose.x - poses[0].x) * dx + (pose.y - poses[0].y) * dy;
            let way = (ways[0] + along.clamp(0.0, length)).clamp(low, high);
            let distance = self.at(way).distance_to(pose);
            if distance < best.0 {
                best = (distance, way);
            }
        }
        best.1.min(self.length())
    }

    /// The point after a way of `way` m, interpolated; the goal beyond it.
    pub(super) fn at(&self, way: f64) -> Pose2D {
        let next = self.ways.partition_point(|&end| end < way);
        let (Some(&b), Some(&end)) = (self.poses.get(next), self.ways.get(next)) else {
            return self.goal();
        };
        let Some(before) = next.checked_sub(1) else {
            return b;
        };
        let (a, start) = (self.poses[before], self.ways[before]);
        let share = (way - start) / (end - start);
        Pose2D::new(a.x + share * (b.x - a.x), a.y + share * (b.y - a.y), b.theta)
    }

    /// The poses, in their order.
    pub(super) fn poses(&self) -> &[Pose2D] {
        &self.poses
    }
}

/// Returns the curvature of the arc from the origin, along x, to a point in the frame of the base, 1/m, left
/// positive: Coulter, "Implementation of the pure pursuit path tracking algorithm", CMU-RI-TR-92-01.
pub(super) fn curvature(point: &Pose2D) -> f64 {
    let squared = point.x * point.x + point.y * point.y;
    if squared > 0.0 {
        2.0 * point.y / squared
    } else {
        0.0
    }
}
