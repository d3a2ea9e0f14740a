//! What a picture of a drive needs: where its robots were, who acted there, and where its targets were.

use std::collections::BTreeMap;

use jde_core::Nanos;
use jde_types::Pose2D;

use super::sight::{Seen, Sight};
use super::tally::Takeover;

/// Samples of the path between two scans that are kept: a scan a second is enough to show a building.
const SAMPLES_A_SCAN: usize = 10;

/// A drive, sampled.
#[derive(Default)]
pub(crate) struct Trace {
    /// Where each robot was, by its driver's place in the application.
    pub(crate) paths: BTreeMap<usize, Vec<Sample>>,
    /// When somebody took over, who, and which robots he acts for.
    pub(crate) takeovers: Vec<(Nanos, usize, Vec<usize>)>,
    /// Targets in the order of the mission, as far as they were named; those of a route once, however often it is gone.
    pub(crate) targets: Vec<(f64, f64)>,
    /// How many were reached.
    pub(crate) reached: usize,
    /// What the laser saw, if it is to be kept.
    pub(crate) scans: Option<Vec<(f64, f64)>>,
}

/// Where the robot was.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Sample {
    /// When.
    pub(crate) time: Nanos,
    /// Where, in the world, or in the frame of the odometry where there is no ground truth.
    pub(crate) pose: Pose2D,
    /// Who acted.
    pub(crate) acting: Option<usize>,
}

impl Trace {
    /// Nothing so far; `scans` if what the laser sees is to be kept, for want of a world.
    pub(crate) fn new(scans: bool) -> Self {
        Self {
            scans: scans.then(Vec::new),
            ..Self::default()
        }
    }

    /// Adds what is seen now. `acting` are those who act.
    pub(crate) fn add(&mut self, time: Nanos, sight: &mut Sight, seen: &Seen, acting: &[usize]) {
        if let Some(progress) = seen.mission.as_ref().filter(|progress| progress.of_places) {
            self.reached = progress.reached as usize;
            if self.targets.is_empty() {
                self.targets = sight.route();
            }
            // Without a route the targets are known one by one.
            if let Some(target) = progress.target.filter(|_| self.reached == self.targets.len())
                && self.reached < progress.total as usize
            {
                self.targets.push(sight.in_path(target));
            }
        }
        for (robot, pose) in seen.places.iter().copied() {
            let acting = sight.acts_for(robot, acting);
            let path = self.paths.entry(robot).or_default();
            if let Some(scans) = &mut self.scans
                && path.len().is_multiple_of(SAMPLES_A_SCAN)
            {
                scans.extend(sight.scan(robot, pose));
            }
            path.push(Sample { time, pose, acting });
        }
    }

    /// Adds a takeover by a schema that acts.
    pub(crate) fn took_over(&mut self, takeover: &Takeover, sight: Option<&Sight>) {
        let robots = |to| sight.map_or_else(Vec::new, |sight| sight.robots_of(to).collect());
        self.takeovers
            .extend(takeover.to.map(|to| (takeover.time, to, robots(to))));
    }

    /// Where a robot was at a time, as far as is known.
    pub(crate) fn place(&self, robot: usize, time: Nanos) -> Option<Pose2D> {
        let path = self.paths.get(&robot)?;
        let after = path.partition_point(|sample| sample.time < time);
        path.get(after).or(path.last()).map(|sample| sample.pose)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_place_of_a_takeover_is_the_next_sample_of_the_path() {
        let sample = |time, x| Sample {
            time,
            pose: Pose2D::new(x, 0.0, 0.0),
            acting: None,
        };
        let trace = Trace {
            paths: BTreeMap::from([(3, vec![sample(0, 0.0), sample(100, 1.0)])]),
            ..Trace::default()
        };
        assert_eq!(trace.place(3, 0).unwrap().x, 0.0);
        assert_eq!(trace.place(3, 40).unwrap().x, 1.0);
        assert_eq!(trace.place(3, 400).unwrap().x, 1.0);
        assert_eq!(trace.place(2, 0), None);
    }
}
