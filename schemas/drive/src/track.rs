//! A path as a controller follows it: the way along it, and where the robot is. A path of a single point is a
//! place to go to.

use jde_schema::prelude::*;
use jde_schema::types::Path;

/// How far along the path the nearest point may be from the last one, m. A path that crosses itself is
/// then followed in its order.
const WINDOW: f64 = 1.5;

/// A path with the way along it, and where the robot is on it.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Track {
    poses: Vec<Pose2D>,
    /// Way from the start to each pose, m.
    ways: Vec<f64>,
    /// The way along the track so far, m; none before the robot was on it.
    progress: Option<f64>,
}

impl Track {
    /// Follows the published path if the import is bound, or else the route. The progress begins anew with
    /// another path. Returns whether there is one.
    pub(crate) fn follow(&mut self, cx: &Context, path: &Import<Path>, route: &Modulation<Route>) -> bool {
        if path.is_bound(cx) {
            let path = path.get(cx);
            let poses = path.iter().flat_map(|path| path.poses.iter());
            self.replace(poses.map(|stamped| stamped.pose.into()))
        } else {
            self.replace(route.sample(cx).poses.iter().copied())
        }
    }

    /// Replaces the poses, and keeps the memory; with a pose that is not a number, there is none. Returns
    /// whether there is one.
    pub(crate) fn replace(&mut self, poses: impl Iterator<Item = Pose2D>) -> bool {
        let mut count = 0;
        for pose in poses {
            if !pose.is_finite() {
                count = 0;
                break;
            }
            if self.poses.get(count) != Some(&pose) {
                self.truncate(count);
                let way = match (self.poses.last(), self.ways.last()) {
                    (Some(last), Some(way)) => way + last.distance_to(&pose),
                    _ => 0.0,
                };
                self.poses.push(pose);
                self.ways.push(way);
            }
            count += 1;
        }
        if count < self.poses.len() {
            self.truncate(count);
        }
        count > 0
    }

    fn truncate(&mut self, count: usize) {
        self.poses.truncate(count);
        self.ways.truncate(count);
        self.progress = None;
    }

    /// Takes the pose of the robot, and returns the way along the track so far, m.
    pub(crate) fn advance(&mut self, pose: &Pose2D) -> f64 {
        let progress = self.nearest(pose, self.progress);
        self.progress = Some(progress);
        progress
    }

    /// The way left to the goal, m.
    pub(crate) fn left(&self) -> f64 {
        self.length() - self.progress.unwrap_or_default()
    }

    /// The mission of a schema that follows the track, with a note for a person.
    pub(crate) fn mission(&self, is_done: bool, note: &str) -> Mission {
        Mission {
            state: if is_done { Mission::DONE } else { Mission::RUNNING },
            reached: is_done.into(),
            total: 1,
            note: Text::truncated(note),
            target: self.goal(),
            distance: self.left(),
            ..Mission::default()
        }
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
        let mut track = Track::default();
        assert!(track.replace(places.iter().map(|&(x, y)| Pose2D::new(x, y, 0.0))));
        track
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
    }

    #[test]
    fn on_a_path_that_crosses_itself_the_order_of_the_path_counts() {
        let cross = track(&[(0.0, 0.0), (4.0, 0.0), (4.0, 2.0), (2.0, 2.0), (2.0, -2.0)]);
        let middle = Pose2D::new(2.0, 0.1, 0.0);
        assert!((cross.nearest(&middle, None) - 9.9).abs() < 1e-9);
        assert!((cross.nearest(&middle, Some(1.5)) - 2.0).abs() < 1e-9);
    }

    #[test]
    fn the_progress_stays_with_the_same_path_and_begins_anew_with_another() {
        let mut track = track(&[(0.0, 0.0), (3.0, 0.0), (3.0, 3.0)]);
        assert_eq!(track.advance(&Pose2D::new(2.0, 0.5, 0.0)), 2.0);
        let again = track.clone();
        assert!(track.replace(again.poses.iter().copied()));
        assert_eq!(track, again);
        assert!(track.replace(again.poses[..2].iter().copied()));
        assert_eq!((track.left(), track.progress), (3.0, None));
        assert!(!track.replace([Pose2D::ORIGIN, Pose2D::new(0.0, f64::NAN, 0.0)].into_iter()));
        assert!(track.poses().is_empty() && !track.replace(core::iter::empty()));
    }
}
