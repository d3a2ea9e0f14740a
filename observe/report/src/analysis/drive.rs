//! Collects the robots' paths, targets, laser scans and, if known, their world. Of several missions only the
//! first is followed, and a remark notes this.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use jde_board::value::{self, Value};
use jde_core::Nanos;
use jde_log::{Channel, DecodeError, LeftOut, Message, RecordedVariable, Recording, value_type};
use jde_ros::{cdr, definition};
use jde_sim::World;
use jde_types::{Body, LaserScan, Mission, Odometry, Pose2D, Route, Truth, Value as _};

use super::columns::Columns;
use super::decimated::Decimated;
use super::robot::{Robot, TruthRange, footprint};
use crate::map::{Drive, Obstacle, Paint, RobotPath, Takeover, Target};

/// Most takeovers stored: more than a picture can show.
const MOST_TAKEOVERS: usize = 2000;
/// Most targets stored.
const MOST_TARGETS: usize = 1000;

/// Collects a drive.
pub(crate) struct DriveCollector {
    topics: Topics,
    robots: Vec<Robot>,
    takeovers: Decimated<Takeover>,
    takeover_count: u64,
    mission: Option<Mission>,
    route: Vec<(f64, f64)>,
    /// Targets from the mission's progress, by the number of targets reached before. The first are missing if
    /// the recording began later.
    found: BTreeMap<usize, (f64, f64)>,
    world: Option<(PathBuf, Result<World, String>)>,
    folder: Option<PathBuf>,
    seed: u64,
}

/// The topics that are read.
#[derive(Default)]
struct Topics {
    mission: Option<String>,
    /// The number of missions that are not followed.
    other_missions: usize,
    route: Option<String>,
    world: Option<Channel>,
    /// Robots that are not drawn, since their odometry has a frame of its own.
    left_out: Vec<String>,
}

/// The collected drive.
#[derive(Default)]
pub(crate) struct DriveSummary {
    pub(crate) drive: Drive,
    pub(crate) mission: Option<Mission>,
    /// Contacts of all robots within the reported time; none without ground truth.
    pub(crate) collisions: Option<u64>,
    /// The least distance to an obstacle, m; none if it occurred before the reported time.
    pub(crate) min_clearance: Option<f64>,
    /// Remarks on what the map shows or lacks.
    pub(crate) remarks: Vec<String>,
}

impl DriveCollector {
    pub(crate) fn new(recording: &Recording) -> Self {
        let metadata = |key: &str| recording.metadata("jde").and_then(|metadata| metadata.get(key));
        let (topics, robots) = Topics::of(recording);
        Self {
            topics,
            robots,
            takeovers: Decimated::new(MOST_TAKEOVERS),
            takeover_count: 0,
            mission: None,
            route: Vec::new(),
            found: BTreeMap::new(),
            world: None,
            folder: metadata("folder").map(PathBuf::from),
            seed: metadata("seed").and_then(|seed| seed.parse().ok()).unwrap_or(0),
        }
    }

    /// Processes a message of a variable. `acting` returns the schema that acts for a robot at present.
    ///
    /// # Errors
    /// The message is no value of its type.
    pub(crate) fn message(
        &mut self,
        columns: Columns,
        time: Nanos,
        reading: &mut Reading<'_>,
        acting: impl Fn(&str) -> Option<usize>,
    ) -> Result<(), DecodeError> {
        let message = reading.message;
        let topic = &message.channel.topic;
        let shows_walls = self.shows_walls();
        if let Some(robot) = self.robots.iter_mut().find(|robot| robot.has(topic)) {
            robot.message(columns, time, reading, shows_walls, acting)?;
        } else if self.topics.mission.as_ref() == Some(topic) {
            if let Some(mission) = reading.read::<Mission>()? {
                self.mission(mission);
            }
        } else if self.topics.route.as_ref() == Some(topic) {
            if let Some(route) = reading.read::<Route>()? {
                self.route = route.poses.iter().map(|pose| (pose.x, pose.y)).collect();
            }
        } else if let Some(channel) = self.topics.world.as_ref().filter(|world| world.topic == *topic)
            && time <= columns.to
            && let Some(Value::Text(path)) = single(channel, message)
        {
            self.world(&path);
        }
        Ok(())
    }

    /// Records that an actor took over, for the robots that satisfy `acts`.
    pub(crate) fn add_takeover(&mut self, to: usize, acts: impl Fn(&str) -> bool) {
        let robots = self.robots.iter().filter(|robot| acts(&robot.name));
        let poses: Vec<Pose2D> = robots.filter_map(|robot| robot.pose).collect();
        for Pose2D { x, y, .. } in &poses {
            self.takeovers.add(Takeover { x: *x, y: *y, to });
        }
        self.takeover_count += u64::from(!poses.is_empty());
    }

    /// Whether there is at most one robot, for which all schemas act.
    pub(crate) fn is_alone(&self) -> bool {
        self.robots.len() <= 1
    }

    /// The owner of the mission that is followed.
    pub(crate) fn mission_owner(&self) -> Option<&str> {
        let topic = self.topics.mission.as_deref()?;
        Some(schema_name(topic.rsplit_once('/')?.0))
    }

    /// Completes the drive. `winners` are the schemas that won for any time. `led_robot` is the robot of the
    /// mission; the first robot if unknown.
    pub(crate) fn finish(
        mut self,
        title: String,
        schema_names: Vec<String>,
        winners: Vec<usize>,
        led_robot: Option<&str>,
    ) -> DriveSummary {
        let mut remarks = Vec::new();
        let targets = self.targets(led_robot);
        if let Some(step) = self
            .robots
            .iter()
            .map(|robot| robot.path.step())
            .max()
            .filter(|step| *step > 1)
        {
            remarks.push(format!("only every {step}th point of the path is shown"));
        }
        if let (others @ 1.., Some(owner)) = (self.topics.other_missions, self.mission_owner()) {
            remarks.push(format!(
                "of {} missions, only that of {owner} is shown",
                others + 1
            ));
        }
        if !self.topics.left_out.is_empty() {
            let names = self.topics.left_out.join(", ");
            remarks.push(format!(
                "the path of {names} is not drawn, because its position relative to the other robots is not known"
            ));
        }
        let truths: Vec<_> = self
            .robots
            .iter_mut()
            .filter_map(|robot| robot.truth.take())
            .collect();
        let has_truth = !truths.is_empty();
        let mut scans = Vec::new();
        let paths = self.robots.into_iter().map(|robot| {
            scans.extend(robot.scans.into_items().into_iter().flatten());
            RobotPath {
                robot: robot.name,
                body: robot.body.as_ref().and_then(footprint),
                points: robot.path.into_items(),
                distance: robot.distance,
            }
        });
        let mut drive = Drive {
            title,
            schema_names,
            winners,
            paths: paths.filter(|path| !path.points.is_empty()).collect(),
            takeovers: self.takeovers.into_items(),
            takeover_count: self.takeover_count,
            targets,
            ..Drive::default()
        };
        match self.world.take() {
            Some((_, Ok(world))) if has_truth => {
                drive.bounds = Some(world.bounds());
                drive.shapes = world.shapes().map(Obstacle::from).collect();
                drive.paint = world.paint().map(Paint::from).collect();
            }
            Some((_, Ok(_))) => remarks.push(
                "walls are not drawn, because the recording has no ground truth of the robot's pose"
                    .to_owned(),
            ),
            Some((path, Err(reason))) => remarks.push(format!(
                "walls are not drawn: the world {} can no longer be read: {reason}",
                path.display()
            )),
            None => {}
        }
        if drive.shapes.is_empty() {
            drive.scans = scans;
            if !drive.scans.is_empty() && drive.has_path() {
                remarks.push("dots are laser measurements, at most one scan per second".to_owned());
            }
        }
        let nearest = truths
            .iter()
            .min_by(|a, b| a.last.min_clearance.total_cmp(&b.last.min_clearance));
        DriveSummary {
            mission: self.mission,
            collisions: has_truth.then(|| {
                let contacts = truths.iter().map(TruthRange::collisions);
                contacts.fold(0, u64::saturating_add)
            }),
            min_clearance: nearest.and_then(TruthRange::min_clearance),
            drive,
            remarks,
        }
    }

    /// Whether the walls are drawn, which makes laser points unnecessary.
    fn shows_walls(&self) -> bool {
        matches!(self.world, Some((_, Ok(_)))) && self.robots.iter().any(|robot| robot.truth_topic.is_some())
    }

    fn mission(&mut self, mission: Mission) {
        let place = (mission.target.x, mission.target.y);
        // A robot that still has to drive somewhere is never at distance 0.
        let is_place = place != (0.0, 0.0) || mission.distance > 0.0;
        if is_place && mission.reached < mission.total && self.found.len() < MOST_TARGETS {
            self.found.entry(mission.reached as usize).or_insert(place);
        }
        self.mission = Some(mission);
    }

    /// The targets in the frame of the path; those of the route if there is one.
    fn targets(&self, led_robot: Option<&str>) -> Vec<Target> {
        let of = |led_robot: &str| self.robots.iter().find(|robot| robot.name == led_robot);
        let robot = led_robot.and_then(of).or(self.robots.first());
        let anchor = robot.and_then(|robot| robot.anchor.as_ref());
        // Without any position, the mission does not consist of places.
        if self.found.is_empty() {
            return Vec::new();
        }
        let reached = self.mission.map_or(0, |mission| mission.reached as usize);
        let target = |(before, (x, y)): (usize, (f64, f64))| {
            let (x, y) = match anchor {
                Some((truth, odometry)) => {
                    let place = truth.transform(&odometry.localize(&Pose2D::new(x, y, 0.0)));
                    (place.x, place.y)
                }
                None => (x, y),
            };
            Target {
                number: before + 1,
                x,
                y,
                reached: before < reached,
            }
        };
        if self.route.is_empty() {
            let found = self.found.iter();
            found.map(|(before, place)| target((*before, *place))).collect()
        } else {
            self.route.iter().copied().enumerate().map(target).collect()
        }
    }

    fn world(&mut self, path: &str) {
        if path.is_empty() {
            return;
        }
        let path = match &self.folder {
            Some(folder) => folder.join(path),
            None => PathBuf::from(path),
        };
        if self.world.as_ref().is_some_and(|(known, _)| *known == path) {
            return;
        }
        let world = load(&path, self.seed);
        self.world = Some((path, world));
    }
}

/// Reads a world from a path that the recording names. Refuses anything but a regular file.
fn load(path: &Path, seed: u64) -> Result<World, String> {
    match std::fs::metadata(path) {
        Ok(about) if !about.is_file() => Err("it is not a regular file".to_owned()),
        Ok(_) => World::load(path, seed).map_err(|error| error.to_string()),
        Err(error) => Err(error.to_string()),
    }
}

impl Topics {
    fn of(recording: &Recording) -> (Self, Vec<Robot>) {
        let all = |type_name: &str| {
            let of_type = recording
                .channels()
                .filter(|channel| channel.type_name == type_name && channel.encoding == "cdr");
            of_type.map(|channel| channel.topic.clone()).collect::<Vec<_>>()
        };
        let owner = |topic: &str| topic.rsplit_once('/').map(|(owner, _)| owner.to_owned());
        let [truths, odometries, lasers, bodies] = [
            &Truth::describe(),
            &Odometry::describe(),
            &LaserScan::describe(),
            &Body::describe(),
        ]
        .map(|of| all(&definition::name(of)));
        let commanded = |topic: &String| {
            recording.channels().any(|channel| {
                let is_command = channel
                    .metadata
                    .get("access")
                    .is_some_and(|access| access == "command");
                is_command && owner(&channel.topic) == owner(topic)
            })
        };
        // Schemas that correct odometry publish it as well. A robot is a schema that takes commands.
        let (own, mut others): (Vec<_>, Vec<_>) = odometries.iter().partition(|topic| commanded(topic));
        let mut naming_topics: Vec<&String> = if !truths.is_empty() {
            truths.iter().collect()
        } else if !own.is_empty() {
            others.clear();
            own
        } else {
            others.drain(..others.len().min(1)).collect()
        };
        let mut left_out = Vec::new();
        if !truths.is_empty() {
            // The odometry of the others has frames of its own.
            let known = |topic: &&String| truths.iter().any(|truth| owner(truth) == owner(topic));
            left_out = odometries
                .iter()
                .filter(|topic| commanded(topic) && !known(topic))
                .collect();
        } else {
            left_out.append(&mut others);
        }
        if naming_topics.is_empty() {
            naming_topics = lasers.iter().take(1).collect();
        }
        let is_single = naming_topics.len() == 1;
        // The robot's own topic of a kind; for a single robot, any topic of that kind.
        let of = |robot: &str, topics: &[String]| {
            let own = topics.iter().find(|topic| owner(topic) == owner(robot));
            own.or(topics.first().filter(|_| is_single)).cloned()
        };
        let count = naming_topics.len();
        let robots = naming_topics.iter().map(|topic| Robot {
            body_topic: of(topic, &bodies),
            truth_topic: of(topic, &truths),
            odometry_topic: of(topic, &odometries),
            laser_topic: of(topic, &lasers),
            ..Robot::new(schema_name(&owner(topic).unwrap_or_default()), count)
        });
        let robots = robots.collect();
        let missions = all(&definition::name(&Mission::describe()));
        let mission = missions.first().cloned();
        let mission_owner = mission.as_deref().and_then(owner);
        let routes = all(&definition::name(&Route::describe()));
        let world = recording.channels().find(|channel| {
            let metadata = |key: &str| channel.metadata.get(key).map_or("", String::as_str);
            metadata("access") == "modulation"
                && metadata("unit") == "file"
                && metadata("variable").ends_with(".world")
        });
        let topics = Self {
            route: routes.into_iter().find(|topic| owner(topic) == mission_owner),
            world: world.cloned(),
            mission,
            other_missions: missions.len().saturating_sub(1),
            left_out: left_out
                .into_iter()
                .map(|topic| schema_name(&owner(topic).unwrap_or_default()).to_owned())
                .collect(),
        };
        (topics, robots)
    }
}

/// The name of the schema that owns the topics below a prefix.
fn schema_name(owner: &str) -> &str {
    owner.trim_start_matches('/')
}

/// A message of a variable, and the report of what of it cannot be read.
pub(crate) struct Reading<'a> {
    pub(crate) message: &'a Message,
    pub(crate) variable: &'a RecordedVariable,
    pub(crate) left_out: &'a mut LeftOut,
}

impl Reading<'_> {
    /// Decodes the message as a value of a type.
    pub(super) fn read<T: jde_types::Value>(&mut self) -> Result<Option<T>, DecodeError> {
        self.variable.decode_as(&self.message.data, self.left_out)
    }
}

/// Decodes a message that is one number.
pub(super) fn number(message: &Message) -> Option<f64> {
    single(&message.channel, message)?.as_number()
}

/// Decodes a message of one text or number, of any type.
fn single(channel: &Channel, message: &Message) -> Option<Value> {
    let value_type = value_type(channel).ok()?;
    let bytes = cdr::decode(&value_type, &message.data).ok()?;
    Some(value::decode(&value_type, &bytes).into_only_field())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::analysis::robot::MAX_POINTS;

    #[test]
    fn distance_and_takeovers_count_dropped_points_too() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("empty.mcap");
        crate::tests::recorder(&file, None).finish();
        let mut collector = DriveCollector::new(&Recording::open(&file).unwrap());
        collector.robots.push(Robot::new("robot", 1));
        let columns = Columns::new(0, 1_000_000, 100);
        let no_actor = |_: &str| None;
        for step in 0..=100_000_u64 {
            collector.robots[0].at(columns, step, Pose2D::new((step % 2) as f64, 0.0, 0.0), no_actor);
            collector.add_takeover(0, |_| true);
        }
        // The pose is lost for a moment.
        collector.robots[0].at(columns, 100_001, Pose2D::new(f64::NAN, 0.0, 0.0), no_actor);
        collector.robots[0].at(columns, 100_002, Pose2D::new(2.0, 0.0, 0.0), no_actor);
        let ending = collector.finish(String::new(), Vec::new(), Vec::new(), None);
        let path = &ending.drive.paths[0];
        assert!(path.points.len() <= MAX_POINTS && ending.drive.takeovers.len() <= MOST_TAKEOVERS);
        assert_eq!((path.distance, ending.drive.takeover_count), (100_002.0, 100_001));
    }
}
