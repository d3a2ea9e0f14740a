//! Where a robot was at the last steps of its world, for sensors that measure over a time.

use std::collections::VecDeque;

use crate::geometry::{Pose2, wrap_angle};
use crate::world::STEP_NS;

/// The poses at the ends of the last steps, the newest first.
#[derive(Debug, Default)]
pub(crate) struct Trail {
    poses: VecDeque<Pose2>,
    capacity: usize,
}

impl Trail {
    /// Creates a trail that covers some seconds.
    pub(crate) fn new(seconds: f64) -> Self {
        let steps = seconds * 1e9 / STEP_NS as f64;
        Self {
            poses: VecDeque::new(),
            capacity: libm::ceil(steps) as usize,
        }
    }

    /// Takes the pose before a step.
    pub(crate) fn push(&mut self, pose: Pose2) {
        if self.capacity > 0 {
            self.poses.truncate(self.capacity - 1);
            self.poses.push_front(pose);
        }
    }

    /// Forgets everything: the robot was put elsewhere, and counts as having been there.
    pub(crate) fn clear(&mut self) {
        self.poses.clear();
    }

    /// Returns the pose some seconds before that of now, straight between two steps. Before its first step the
    /// robot stood.
    pub(crate) fn pose_ago(&self, seconds: f64, now: Pose2) -> Pose2 {
        let steps = seconds.max(0.0) * 1e9 / STEP_NS as f64;
        let whole = libm::floor(steps) as usize;
        let at = |steps: usize| match steps.checked_sub(1) {
            None => now,
            Some(index) => (self.poses.get(index).or(self.poses.back()).copied()).unwrap_or(now),
        };
        let (later, earlier, part) = (at(whole), at(whole + 1), steps - whole as f64);
        Pose2::new(
            later.x + part * (earlier.x - later.x),
            later.y + part * (earlier.y - later.y),
            later.heading + part * wrap_angle(earlier.heading - later.heading),
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_trail_returns_the_poses_of_its_steps_and_those_between_them() {
        let mut trail = Trail::new(0.1);
        for step in 0..50 {
            trail.push(Pose2::new(f64::from(step), 0.0, 3.1 + 0.01 * f64::from(step)));
        }
        let now = Pose2::new(50.0, 0.0, 3.6);
        for (seconds, x) in [
            (0.0, 50.0),
            (0.004, 49.6),
            (0.01, 49.0),
            (0.035, 46.5),
            (0.1, 40.0),
            (9.0, 40.0),
        ] {
            let pose = trail.pose_ago(seconds, now);
            assert!((pose.x - x).abs() < 1e-9, "{seconds}: {pose:?}");
            assert!(
                wrap_angle(pose.heading - 3.1 - 0.01 * x).abs() < 1e-9,
                "{seconds}: {pose:?}"
            );
        }
        trail.clear();
        assert_eq!(trail.pose_ago(0.05, now), now);
        assert_eq!(Trail::new(0.0).pose_ago(0.05, now), now);
    }
}
