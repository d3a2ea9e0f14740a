//! The way that the robot came, as poses of its odometry. It knows no obstacles.

use std::collections::VecDeque;

use jde_schema::types::Pose2D;

/// Distance from one pose to the next, m.
const STEP: f64 = 0.05;
/// The most poses: 10 m.
const MAX_TRAIL_POSES: usize = 200;
/// How far behind the robot the pursued pose is at least, m.
const LOOKAHEAD: f64 = 0.25;
/// A pose that moves farther than this between two calls was set anew, m.
const JUMP: f64 = 1.0;

/// Where the robot was, from long ago to now.
#[derive(Clone, Debug, Default)]
pub(crate) struct Trail(VecDeque<Pose2D>);

impl Trail {
    /// Forgets everything.
    pub(crate) fn clear(&mut self) {
        self.0.clear();
    }

    /// Adds the present pose.
    pub(crate) fn extend(&mut self, pose: &Pose2D) {
        let moved = self.0.back().map_or(f64::INFINITY, |last| last.distance_to(pose));
        if moved > JUMP {
            self.0.clear();
        }
        if moved > STEP {
            self.0.push_back(*pose);
        }
        if self.0.len() > MAX_TRAIL_POSES {
            self.0.pop_front();
        }
    }

    /// Forgets the poses that a robot has passed on its way back, and returns the one to pursue, in the frame
    /// of the base.
    pub(crate) fn retrace(&mut self, pose: &Pose2D) -> Option<Pose2D> {
        while self
            .0
            .back()
            .is_some_and(|last| last.distance_to(pose) < LOOKAHEAD)
        {
            self.0.pop_back();
        }
        self.0.back().map(|last| pose.localize(last))
    }

    /// The poses, from long ago to now.
    pub(crate) fn poses(&self) -> impl Iterator<Item = &Pose2D> {
        self.0.iter()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_robot_that_goes_back_pursues_where_it_was_before() {
        let mut trail = Trail::default();
        for step in 0..=20 {
            trail.extend(&Pose2D::new(f64::from(step) * 0.06, 0.0, 0.0));
        }
        for step in 0..=24 {
            let pose = Pose2D::new(1.2 - f64::from(step) * 0.05, 0.0, 0.0);
            match trail.retrace(&pose) {
                Some(point) => assert!((-0.31..=-0.25).contains(&point.x), "{step}: {point:?}"),
                None => assert!(pose.x < 0.26, "at the beginning: {pose:?}"),
            }
        }
        assert_eq!(trail.poses().count(), 0);
    }

    #[test]
    fn a_pose_that_jumps_begins_anew_and_the_trail_has_an_end() {
        let mut trail = Trail::default();
        for step in 0..1000 {
            trail.extend(&Pose2D::new(f64::from(step) * 0.06, 0.0, 0.0));
        }
        assert_eq!(trail.poses().count(), MAX_TRAIL_POSES);
        trail.extend(&Pose2D::new(0.0, 5.0, 0.0));
        assert_eq!(trail.poses().count(), 1);
    }
}
