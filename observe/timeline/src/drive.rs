//! The drive of a run from above: its robots, its mission, and where schemas took over. Of several missions one is followed.

use jde_core::Nanos;
use jde_types::Pose2D;

use crate::decimated::Decimated;
use crate::hierarchy::Hierarchy;
use crate::mission::MissionTimeline;
use crate::robot::RobotTimeline;
use crate::robot_sources::RobotSources;
use crate::timeline::Timeline;

/// The most points that a picture can show, of all paths, the most scans, and the most takeovers.
const MAX_POINTS: usize = 40_000;
const MAX_SCANS: usize = 2000;
const MAX_TAKEOVERS: usize = 2000;

/// A change of winner.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Takeover {
    /// Metres.
    pub x: f64,
    /// Metres.
    pub y: f64,
    /// The new winner.
    pub to: usize,
}

/// A target of a robot.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Target {
    /// Its number among all targets, from 1.
    pub number: usize,
    /// Metres.
    pub x: f64,
    /// Metres.
    pub y: f64,
    /// Whether the robot has reached it.
    pub reached: bool,
}

/// What happened to the robots of a run, for pictures and summaries. It is fed with values in the order of their times. Its
/// memory is bounded: of many points, every second, fourth, eighth is kept.
#[derive(Clone, Debug)]
pub struct DriveTimeline {
    /// The robots.
    pub robots: Vec<RobotTimeline>,
    /// The mission.
    pub mission: MissionTimeline,
    /// The schema whose mission is followed.
    pub leader: Option<String>,
    takeovers: Decimated<Takeover>,
    /// The number of takeovers.
    pub takeover_count: u64,
}

impl DriveTimeline {
    /// Creates the drive of robots of which nothing is known. What is earlier than `begin` does not count.
    #[must_use]
    pub fn new(robots: Vec<RobotSources>, leader: Option<String>, begin: Nanos) -> Self {
        let count = robots.len().max(1);
        let robot = |sources| RobotTimeline::new(sources, begin, MAX_POINTS / count, MAX_SCANS / count);
        Self {
            robots: robots.into_iter().map(robot).collect(),
            mission: MissionTimeline::default(),
            leader,
            takeovers: Decimated::new(MAX_TAKEOVERS),
            takeover_count: 0,
        }
    }

    /// Adds a takeover by a schema, at the present places of the robots that it acts for. A father takes over together with
    /// one of its children, and does not count.
    pub fn add_takeover(&mut self, to: usize, hierarchy: &Hierarchy) {
        if !hierarchy.is_actor(to) {
            return;
        }
        let is_alone = self.is_alone();
        let robots = self.robots.iter();
        let robots = robots.filter(|robot| is_alone || hierarchy.acts_for(to, &robot.sources.name));
        let poses: Vec<Pose2D> = robots.filter_map(|robot| robot.pose).collect();
        for Pose2D { x, y, .. } in &poses {
            self.takeovers.add(Takeover { x: *x, y: *y, to });
        }
        self.takeover_count += u64::from(!poses.is_empty());
    }

    /// Whether there is at most one robot, for which all schemas act.
    #[must_use]
    pub fn is_alone(&self) -> bool {
        self.robots.len() <= 1
    }

    /// Returns the schema that acts for a robot at present.
    #[must_use]
    pub fn acting_for(robot: &str, is_alone: bool, timeline: &Timeline) -> Option<usize> {
        let mut acting = timeline.acting().into_iter();
        acting.find(|schema| is_alone || timeline.hierarchy().acts_for(*schema, robot))
    }

    /// Returns the robot of the mission; the first one if it is not known.
    #[must_use]
    pub fn led_robot(&self, hierarchy: &Hierarchy) -> Option<&RobotTimeline> {
        let name = self
            .leader
            .as_deref()
            .and_then(|leader| hierarchy.robot_of(leader));
        let led = self
            .robots
            .iter()
            .find(|robot| Some(robot.sources.name.as_str()) == name);
        led.or(self.robots.first())
    }

    /// Returns the targets in the frame of the path.
    #[must_use]
    pub fn targets(&self, hierarchy: &Hierarchy) -> Vec<Target> {
        let robot = self.led_robot(hierarchy);
        let reached = self
            .mission
            .newest()
            .map_or(0, |mission| mission.reached as usize);
        let targets = self.mission.targets().into_iter().map(|(before, place)| {
            let (x, y) = robot.map_or(place, |robot| robot.to_path_frame(place));
            Target {
                number: before + 1,
                x,
                y,
                reached: before < reached,
            }
        });
        targets.collect()
    }

    /// Returns the contacts of all robots; `None` without ground truth.
    #[must_use]
    pub fn collisions(&self) -> Option<u64> {
        let robots = self.robots.iter().filter_map(RobotTimeline::collisions);
        robots.reduce(u64::saturating_add)
    }

    /// Returns when the first contact of any robot began.
    #[must_use]
    pub fn first_contact(&self) -> Option<Nanos> {
        self.robots.iter().filter_map(|robot| robot.first_contact).min()
    }

    /// Returns the least distance of any robot to an obstacle, m; `None` without ground truth, or if the robot that came
    /// nearest was as near before the time that counts.
    #[must_use]
    pub fn min_clearance(&self) -> Option<f64> {
        let known = self.robots.iter().filter(|robot| robot.truth().is_some());
        let clearance =
            |robot: &&RobotTimeline| robot.truth().map_or(f64::INFINITY, |truth| truth.min_clearance);
        let nearest = known.min_by(|one, other| clearance(one).total_cmp(&clearance(other)));
        nearest.and_then(RobotTimeline::min_clearance)
    }

    /// Returns the robots, and the takeovers that are kept.
    #[must_use]
    pub fn into_parts(self) -> (Vec<RobotTimeline>, Vec<Takeover>) {
        (self.robots, self.takeovers.into_items())
    }
}

#[cfg(test)]
mod tests {
    use jde_types::Odometry;

    use super::*;
    use crate::hierarchy::SchemaEntry;

    #[test]
    fn distance_and_takeovers_count_dropped_points_too() {
        let mut hierarchy = Hierarchy::default();
        hierarchy.describe(SchemaEntry::default());
        hierarchy.describe_group("roots", None, [""]);
        let mut drive = DriveTimeline::new(vec![RobotSources::default()], None, 0);
        let at = |x| {
            Odometry::planar(
                jde_types::Time::default(),
                Pose2D::new(x, 0.0, 0.0),
                Default::default(),
            )
        };
        for step in 0..=100_000_u64 {
            drive.robots[0].add_odometry(step, &at((step % 2) as f64), || None);
            drive.add_takeover(0, &hierarchy);
        }
        // The pose is lost for a moment.
        drive.robots[0].add_odometry(100_001, &at(f64::NAN), || None);
        drive.robots[0].add_odometry(100_002, &at(2.0), || None);
        let (distance, count) = (drive.robots[0].distance, drive.takeover_count);
        let (robots, takeovers) = drive.into_parts();
        let (path, _) = robots.into_iter().next().expect("it is there").into_path();
        assert!(path.len() <= MAX_POINTS && takeovers.len() <= MAX_TAKEOVERS);
        assert_eq!((distance, count), (100_002.0, 100_001));
    }
}
