//! The data for the picture of a drive: where its robots were, which schemas acted there, and where the
//! targets were.

use std::collections::BTreeMap;

use jde_core::Nanos;
use jde_types::Pose2D;

use super::sampler::{Observation, Sampler};

/// One laser scan is kept for this many samples of the path: one scan per second is enough to show a
/// building.
const SAMPLES_PER_SCAN: usize = 10;

/// A sampled drive.
#[derive(Default)]
pub(crate) struct DriveTrace {
    /// The path of each robot, by its driver's index in the application.
    pub(crate) paths: BTreeMap<usize, Vec<PathSample>>,
    /// The time of each takeover, ns, the new winner, and the robots that it acts for.
    pub(crate) takeovers: Vec<(Nanos, usize, Vec<usize>)>,
    /// The targets known so far, in the order of the mission. The targets of a route occur once, however
    /// often the route is repeated.
    pub(crate) targets: Vec<(f64, f64)>,
    /// How many targets were reached.
    pub(crate) reached: usize,
    /// Points that the laser saw, if they are kept.
    pub(crate) scans: Option<Vec<(f64, f64)>>,
}

/// One sample of a robot.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct PathSample {
    /// Time, ns.
    pub(crate) time: Nanos,
    /// The pose in the world, or in the frame of the odometry where there is no ground truth.
    pub(crate) pose: Pose2D,
    /// The acting schema.
    pub(crate) acting: Option<usize>,
}

impl DriveTrace {
    /// Creates an empty trace. `scans` is whether to keep the laser's points, which replace a missing world.
    pub(crate) fn new(scans: bool) -> Self {
        Self {
            scans: scans.then(Vec::new),
            ..Self::default()
        }
    }

    /// Adds a sample. `acting` are the schemas that act now.
    pub(crate) fn add(
        &mut self,
        time: Nanos,
        sampler: &mut Sampler,
        observation: &Observation,
        acting: &[usize],
    ) {
        if let Some(progress) = observation
            .mission
            .as_ref()
            .filter(|progress| progress.counts_positions)
        {
            self.reached = progress.reached as usize;
            if self.targets.is_empty() {
                self.targets = sampler.route();
            }
            // Without a route the targets become known one by one.
            if let Some(target) = progress.target.filter(|_| self.reached == self.targets.len())
                && self.reached < progress.total as usize
            {
                self.targets.push(sampler.to_path_frame(target));
            }
        }
        for (robot, pose) in observation.poses.iter().copied() {
            let acting = sampler.find_actor(robot, acting);
            let path = self.paths.entry(robot).or_default();
            if let Some(scans) = &mut self.scans
                && path.len().is_multiple_of(SAMPLES_PER_SCAN)
            {
                scans.extend(sampler.scan(robot, pose, time));
            }
            path.push(PathSample { time, pose, acting });
        }
    }

    /// Adds a takeover by a schema.
    pub(crate) fn add_takeover(&mut self, time: Nanos, schema: usize, sampler: Option<&Sampler>) {
        let robots = sampler.map_or_else(Vec::new, |sampler| sampler.robots_of(schema).collect());
        self.takeovers.push((time, schema, robots));
    }

    /// Returns the pose of a robot in its first sample from a time on, or in its last.
    pub(crate) fn pose_at(&self, robot: usize, time: Nanos) -> Option<Pose2D> {
        let path = self.paths.get(&robot)?;
        let after = path.partition_point(|sample| sample.time < time);
        path.get(after).or(path.last()).map(|sample| sample.pose)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_takeover_is_shown_at_the_next_sample_of_the_path() {
        let sample = |time, x| PathSample {
            time,
            pose: Pose2D::new(x, 0.0, 0.0),
            acting: None,
        };
        let trace = DriveTrace {
            paths: BTreeMap::from([(3, vec![sample(0, 0.0), sample(100, 1.0)])]),
            ..DriveTrace::default()
        };
        assert_eq!(trace.pose_at(3, 0).unwrap().x, 0.0);
        assert_eq!(trace.pose_at(3, 40).unwrap().x, 1.0);
        assert_eq!(trace.pose_at(3, 400).unwrap().x, 1.0);
        assert_eq!(trace.pose_at(2, 0), None);
    }
}
