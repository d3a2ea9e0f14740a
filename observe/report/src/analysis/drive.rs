//! Feeds the drive of a recording: the robots' paths, targets and laser scans; and reads their world, if it is known. Of
//! several missions only the first is followed, and a remark notes this.

use std::path::{Path, PathBuf};

use jde_board::value::{self, Value};
use jde_core::Nanos;
use jde_drawing::map::DriveMap;
use jde_log::{Channel, DecodeError, LeftOut, RecordedMessage, RecordedVariable, Recording, value_type};
use jde_ros::{cdr, definition};
use jde_sim::World;
use jde_timeline::{DriveTimeline, Export, Hierarchy, RobotSources, Timeline};
use jde_types::{Body, LaserScan, Mission, Odometry, Route, Truth, Value as _};

/// Collects a drive.
pub(crate) struct DriveCollector {
    pub(crate) timeline: DriveTimeline,
    topics: Topics,
    world: Option<(PathBuf, Result<World, String>)>,
    folder: Option<PathBuf>,
    seed: u64,
}

/// The topics that are read, but those of robots.
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
    pub(crate) drive: DriveMap,
    pub(crate) mission: Option<Mission>,
    /// Contacts of all robots within the reported time; none without ground truth.
    pub(crate) collisions: Option<u64>,
    /// The least distance to an obstacle, m; none if it occurred before the reported time.
    pub(crate) min_clearance: Option<f64>,
    /// Remarks on what the map shows or lacks.
    pub(crate) remarks: Vec<String>,
}

impl DriveCollector {
    /// Collects what is not earlier than `begin`.
    pub(crate) fn new(recording: &Recording, begin: Nanos) -> Self {
        let metadata = |key: &str| recording.metadata("jde").and_then(|metadata| metadata.get(key));
        let (topics, robots) = Topics::of(recording);
        let leader = topics.mission.as_deref().map(|topic| owner(topic).to_owned());
        Self {
            timeline: DriveTimeline::new(robots, leader, begin),
            topics,
            world: None,
            folder: metadata("folder").map(PathBuf::from),
            seed: metadata("seed").and_then(|seed| seed.parse().ok()).unwrap_or(0),
        }
    }

    /// Processes a message of a variable.
    ///
    /// # Errors
    /// The message is no value of its type.
    pub(crate) fn message(
        &mut self,
        time: Nanos,
        reading: &mut MessageDecoder<'_>,
        timeline: &Timeline,
    ) -> Result<(), DecodeError> {
        let message = reading.message;
        let topic = Some(&message.channel.topic);
        let (shows_walls, is_alone) = (self.shows_walls(), self.timeline.is_alone());
        for robot in &mut self.timeline.robots {
            let sources = &robot.sources;
            let (truth, odometry) = (sources.truth.as_ref(), sources.odometry.as_ref());
            let (laser, body) = (sources.laser.as_ref(), sources.body.as_ref());
            let name = sources.name.clone();
            let acting = || DriveTimeline::acting_for(&name, is_alone, timeline);
            if truth == topic {
                if let Some(truth) = reading.read::<Truth>()? {
                    robot.add_truth(time, truth, message.sequence <= 1, acting);
                }
            } else if odometry == topic {
                if let Some(odometry) = reading.read::<Odometry>()? {
                    robot.add_odometry(time, &odometry, acting);
                }
            } else if body == topic {
                robot.body = reading.read::<Body>()?;
            } else if laser == topic {
                if !shows_walls
                    && robot.wants_scan(time)
                    && let Some(scan) = reading.read::<LaserScan>()?
                {
                    robot.add_scan(time, &scan);
                }
            } else {
                continue;
            }
            return Ok(());
        }
        if self.topics.mission.as_ref() == topic {
            if let Some(mission) = reading.read::<Mission>()? {
                self.timeline.mission.add(Some(mission));
            }
        } else if self.topics.route.as_ref() == topic {
            if let Some(route) = reading.read::<Route>()? {
                self.timeline.mission.set_route(&route);
            }
        } else if let Some(channel) = self.topics.world.as_ref()
            && Some(&channel.topic) == topic
            && let Some(Value::Text(path)) = single(channel, message)
        {
            self.world(&path);
        }
        Ok(())
    }

    /// Completes the drive. `winners` are the schemas that won for any time.
    pub(crate) fn finish(
        mut self,
        title: String,
        hierarchy: &Hierarchy,
        winners: Vec<usize>,
    ) -> DriveSummary {
        let mut remarks = Vec::new();
        let steps = self.timeline.robots.iter().map(|robot| robot.path_step());
        if let Some(step) = steps.max().filter(|step| *step > 1) {
            remarks.push(format!("only every {step}th point of the path is shown"));
        }
        if let (others @ 1.., Some(leader)) = (self.topics.other_missions, &self.timeline.leader) {
            remarks.push(format!(
                "of {} missions, only that of {leader} is shown",
                others + 1
            ));
        }
        if !self.topics.left_out.is_empty() {
            let names = self.topics.left_out.join(", ");
            remarks.push(format!(
                "the path of {names} is not drawn, because its position relative to the other robots is not known"
            ));
        }
        let mission = self.timeline.mission.newest().copied();
        let (collisions, min_clearance) = (self.timeline.collisions(), self.timeline.min_clearance());
        let mut drive = DriveMap {
            title,
            winners,
            ..DriveMap::of(self.timeline, hierarchy)
        };
        match self.world.take() {
            Some((_, Ok(world))) if collisions.is_some() => drive.set_world(&world),
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
        if !drive.shapes.is_empty() {
            drive.scans.clear();
        } else if !drive.scans.is_empty() && drive.has_path() {
            remarks.push("dots are laser measurements, at most one scan per second".to_owned());
        }
        DriveSummary {
            mission,
            collisions,
            min_clearance,
            drive,
            remarks,
        }
    }

    /// Whether the walls are drawn, which makes laser points unnecessary.
    fn shows_walls(&self) -> bool {
        let mut robots = self.timeline.robots.iter();
        matches!(self.world, Some((_, Ok(_)))) && robots.any(|robot| robot.sources.truth.is_some())
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
    fn of(recording: &Recording) -> (Self, Vec<RobotSources>) {
        let all = |name: &str| {
            let of_type = recording
                .channels()
                .filter(|channel| channel.type_name == name && channel.encoding == "cdr");
            let export = |channel: &Channel| Export {
                owner: owner(&channel.topic).to_owned(),
                key: channel.topic.clone(),
            };
            of_type.map(export).collect::<Vec<_>>()
        };
        let is_commanded = |robot: &str| {
            recording.channels().any(|channel| {
                let access = channel.metadata.get("access");
                access.is_some_and(|access| access == "command") && owner(&channel.topic) == robot
            })
        };
        let (robots, left_out) = RobotSources::find(|of| all(&definition::name(of)), is_commanded);
        let missions = all(&definition::name(&Mission::describe()));
        let mission = missions.first();
        let route = all(&definition::name(&Route::describe()))
            .into_iter()
            .find(|route| mission.is_some_and(|mission| mission.owner == route.owner));
        let world = recording.channels().find(|channel| {
            let metadata = |key: &str| channel.metadata.get(key).map_or("", String::as_str);
            metadata("access") == "modulation"
                && metadata("unit") == "file"
                && metadata("variable").ends_with(".world")
        });
        let topics = Self {
            route: route.map(|route| route.key),
            world: world.cloned(),
            mission: mission.map(|mission| mission.key.clone()),
            other_missions: missions.len().saturating_sub(1),
            left_out,
        };
        (topics, robots)
    }
}

/// The name of the schema that owns a topic.
fn owner(topic: &str) -> &str {
    let owner = topic.rsplit_once('/').map_or("", |(owner, _)| owner);
    owner.trim_start_matches('/')
}

/// A message of a variable, and the report of what of it cannot be read.
pub(crate) struct MessageDecoder<'a> {
    pub(crate) message: &'a RecordedMessage,
    pub(crate) variable: &'a RecordedVariable,
    pub(crate) left_out: &'a mut LeftOut,
}

impl MessageDecoder<'_> {
    /// Decodes the message as a value of a type.
    pub(super) fn read<T: jde_types::Value>(&mut self) -> Result<Option<T>, DecodeError> {
        self.variable.decode_as(&self.message.data, self.left_out)
    }
}

/// Decodes a message that is one number.
pub(super) fn number(message: &RecordedMessage) -> Option<f64> {
    single(&message.channel, message)?.as_number()
}

/// Decodes a message of one text or number, of any type.
fn single(channel: &Channel, message: &RecordedMessage) -> Option<Value> {
    let value_type = value_type(channel).ok()?;
    let bytes = cdr::decode(&value_type, &message.data).ok()?;
    Some(value::decode(&value_type, &bytes).into_only_field())
}
