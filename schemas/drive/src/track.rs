//! A path with the way along it: where the robot is on it, and the point further on. A path of a single point
//! is a place to go to.

use jde_schema::types::Pose2D;

/// How far along the path the nearest point may be from the last one, m. A path that crosses itself is
/// then followed in its order.
const WINDOW: f64 = 1.5;

/// A path with the way along it.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Track {
    poses: Vec<Pose2D>,
    /// Way from the start to each pose, m.
    ways: Vec<f64>,
}

impl Track {
    /// Returns a track; `None` without poses, or with one that is not a number.
    pub(crate) fn new(poses: impl Iterator<Item = Pose2D>) -> Option<Self> {
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
    pub(crate) fn goal(&self) -> Pose2D {
        self.poses.last().copied().unwrap_or_default()
    }

    /// The way from the start to the goal, m.
    pub(crate) fn length(&self) -> f64 {
        self.ways.last().copied().unwrap_or_default()
    }

    /// The way to the point nearest to `pose`, m, not before `progress` and not far beyond it; with no
    /// progress, the first such point of the whole path.
    pub(crate) fn nearest(&self, pose: &Pose2D, progress: Option<f64>) -> f64 {
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
    pub(crate) fn at(&self, way: f64) -> Pose2D {
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
    pub(crate) fn poses(&self) -> &[Pose2D] {
        &self.poses
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn track(places: &[(f64, f64)]) -> Track {
        Track::new(places.iter().map(|&(x, y)| Pose2D::new(x, y, 0.0))).expect("a path")
    }

    #[test]
    fn a_track_interpolates_between_its_poses() {
        let corner = track(&[(0.0, 0.0), (2.0, 0.0), (2.0, 0.0), (2.0, 3.0)]);
        assert_eq!(corner.length(), 5.0);
        for (way, x, y) in [(0.0, 0.0, 0.0), (1.5, 1.5, 0.0), (3.0, 2.0, 1.0), (9.0, 2.0, 3.0)] {
            let place = corner.at(way);
            assert!((place.x - x).hypot(place.y - y) < 1e-12, "after {way} m");
        }
        assert_eq!(track(&[(1.0, 2.0)]).at(0.5), Pose2D::new(1.0, 2.0, 0.0));
        assert_eq!(Track::new(core::iter::empty()), None);
        assert_eq!(Track::new([Pose2D::new(0.0, f64::NAN, 0.0)].into_iter()), None);
    }

    #[test]
    fn on_a_path_that_crosses_itself_the_order_of_the_path_counts() {
        let cross = track(&[(0.0, 0.0), (4.0, 0.0), (4.0, 2.0), (2.0, 2.0), (2.0, -2.0)]);
        let middle = Pose2D::new(2.0, 0.1, 0.0);
        assert!((cross.nearest(&middle, None) - 9.9).abs() < 1e-9);
        assert!((cross.nearest(&middle, Some(1.5)) - 2.0).abs() < 1e-9);
    }
}
