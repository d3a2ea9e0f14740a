//! Where the robot of a recording went: its path, targets, what its laser saw, and the world it drove in if that is known. Of several
//! robots the first is followed, and all count for collisions.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use jde_board::value::{self, Value};
use jde_core::Nanos;
use jde_log::{Channel, Message, Recording};
use jde_ros::{cdr, definition};
use jde_sim::{RobotConfig, World};
use jde_types::{LaserScan, Mission, Odometry, Pose2D, Route, Truth, Value as _};

use super::columns::Columns;
use super::thinned::Thinned;
use crate::map::{Drive, Moment, Takeover, Target, Thing, is_placed};

/// Most places of the path, takeovers and scans that are kept: more than a picture can show.
const MOST_PLACES: usize = 40_000;
const MOST_TAKEOVERS: usize = 2000;
const MOST_SCANS: usize = 2000;
/// Time between two scans that are looked at: a scan a second is enough to show a building.
const SCAN: Nanos = 1_000_000_000;
/// Most targets.
const MOST_TARGETS: usize = 1000;

/// Collects it.
pub(crate) struct Course {
    topics: Topics,
    /// By topic, what is true of every robot.
    truths: BTreeMap<String, Known>,
    odometry: Option<Pose2D>,
    pose: Option<Pose2D>,
    /// The same place in the frame of the truth and of the odometry, seen first.
    anchor: Option<(Pose2D, Pose2D)>,
    path: Thinned<Moment>,
    /// How far it drove, m, and from where it goes on; not thinned.
    distance: f64,
    place: Option<Pose2D>,
    takeovers: Thinned<Takeover>,
    takeover_count: u64,
    scans: Thinned<Vec<(f64, f64)>>,
    scanned: Option<Nanos>,
    mission: Option<Mission>,
    route: Vec<(f64, f64)>,
    /// Targets that were known one by one, by how many were reached before: of a recording begun later the first are missing.
    found: BTreeMap<usize, (f64, f64)>,
    world: Option<(PathBuf, Result<World, String>)>,
    radius: Option<f64>,
    folder: Option<PathBuf>,
    seed: u64,
}

/// Which topic says what.
#[derive(Default)]
struct Topics {
    truths: Vec<String>,
    odometry: Option<String>,
    laser: Option<String>,
    mission: Option<String>,
    route: Option<String>,
    world: Option<Channel>,
    radius: Option<Channel>,
}

/// What is true of a robot, whose counts go back to its start.
struct Known {
    /// Before the stretch that is told; none if it began in it.
    before: Option<Truth>,
    last: Truth,
}

/// What is known at the end.
#[derive(Default)]
pub(crate) struct Ending {
    pub(crate) drive: Drive,
    pub(crate) mission: Option<Mission>,
    /// Contacts of all robots in the stretch that is told; none without ground truth.
    pub(crate) collisions: Option<u64>,
    /// The least gap to anything, m; none if that was before.
    pub(crate) min_clearance: Option<f64>,
    /// How far it drove, m.
    pub(crate) distance: Option<f64>,
    /// What the map shows of its surroundings and why.
    pub(crate) remarks: Vec<String>,
}

impl Course {
    pub(crate) fn new(recording: &Recording) -> Self {
        let said = |key: &str| recording.metadata("jde").and_then(|said| said.get(key));
        Self {
            topics: Topics::of(recording),
            truths: BTreeMap::new(),
            odometry: None,
            pose: None,
            anchor: None,
            path: Thinned::new(MOST_PLACES),
            distance: 0.0,
            place: None,
            takeovers: Thinned::new(MOST_TAKEOVERS),
            takeover_count: 0,
            scans: Thinned::new(MOST_SCANS),
            scanned: None,
            mission: None,
            route: Vec::new(),
            found: BTreeMap::new(),
            world: None,
            radius: None,
            folder: said("folder").map(PathBuf::from),
            seed: said("seed").and_then(|seed| seed.parse().ok()).unwrap_or(0),
        }
    }

    /// Takes in a message. `acting` is who acts now.
    pub(crate) fn message(
        &mut self,
        columns: Columns,
        time: Nanos,
        message: &Message,
        acting: Option<usize>,
    ) {
        let topic = &message.channel.topic;
        if self.topics.truths.contains(topic) {
            if let Some(truth) = read::<Truth>(message) {
                let followed = self.topics.truths.first() == Some(topic);
                self.known(columns, time, message, truth);
                if followed {
                    self.at(columns, time, truth.pose, acting);
                }
            }
        } else if self.topics.odometry.as_ref() == Some(topic) {
            if let Some(odometry) = read::<Odometry>(message) {
                self.odometry = Some(odometry.pose2d());
                if self.topics.truths.is_empty() {
                    self.at(columns, time, odometry.pose2d(), acting);
                }
            }
        } else if self.topics.laser.as_ref() == Some(topic) {
            self.laser(columns, time, message);
        } else if self.topics.mission.as_ref() == Some(topic) {
            if let Some(mission) = read::<Mission>(message) {
                self.mission(mission);
            }
        } else if self.topics.route.as_ref() == Some(topic) {
            if let Some(route) = read::<Route>(message) {
                self.route = route.poses.iter().map(|pose| (pose.x, pose.y)).collect();
            }
        } else if let Some(channel) = self.topics.world.as_ref().filter(|world| world.topic == *topic) {
            if let Some(Value::Text(path)) = single(channel, message).filter(|_| time <= columns.to) {
                self.world(&path);
            }
        } else if let Some(channel) = self
            .topics
            .radius
            .as_ref()
            .filter(|radius| radius.topic == *topic)
            && let Some(Value::Float(radius)) = single(channel, message)
        {
            self.radius = Some(radius);
        }
        if let (None, Some(truth), Some(odometry)) = (self.anchor, self.pose, self.odometry)
            && !self.topics.truths.is_empty()
        {
            self.anchor = Some((truth, odometry));
        }
    }

    /// Somebody who acts takes over.
    pub(crate) fn took_over(&mut self, to: usize) {
        if let Some(Pose2D { x, y, .. }) = self.pose {
            self.takeovers.add(Takeover { x, y, to });
            self.takeover_count += 1;
        }
    }

    /// Nothing more comes. `winners` are those of the schemas that won for any time.
    pub(crate) fn finish(mut self, title: String, schema_names: Vec<String>, winners: Vec<usize>) -> Ending {
        let mut remarks = Vec::new();
        let targets = self.targets();
        if self.path.step() > 1 {
            remarks.push(format!("of the path every {}th place is shown", self.path.step()));
        }
        let path = self.path.into_items();
        let mut drive = Drive {
            title,
            schema_names,
            winners,
            distance: self.distance,
            takeovers: self.takeovers.into_items(),
            takeover_count: self.takeover_count,
            targets,
            ..Drive::default()
        };
        let has_truth = !self.truths.is_empty();
        match self.world.take() {
            Some((_, Ok(world))) if has_truth => {
                drive.bounds = Some(world.bounds());
                drive.shapes = world.shapes().map(Thing::from).collect();
                drive.robot_radius = self
                    .radius
                    .filter(|radius| *radius > 0.0)
                    .unwrap_or_else(|| RobotConfig::default().radius);
            }
            Some((_, Ok(_))) => remarks.push(
                "walls are not drawn: the recording has no ground truth that says where the robot was among them".to_owned(),
            ),
            Some((path, Err(why))) => remarks.push(format!(
                "walls are not drawn: the world {} cannot be read any more: {why}",
                path.display()
            )),
            None => {}
        }
        if drive.shapes.is_empty() {
            drive.scans = self.scans.into_items().into_iter().flatten().collect();
            if !drive.scans.is_empty() && !path.is_empty() {
                remarks.push("dots are what the laser saw, a scan a second at most".to_owned());
            }
        }
        drive.path = path;
        let nearest = self
            .truths
            .values()
            .min_by(|one, other| one.last.min_clearance.total_cmp(&other.last.min_clearance));
        Ending {
            distance: (drive.path.len() > 1).then_some(drive.distance),
            mission: self.mission,
            collisions: has_truth.then(|| {
                let contacts = self.truths.values().map(Known::collisions);
                contacts.fold(0, u64::saturating_add)
            }),
            min_clearance: nearest.and_then(Known::min_clearance),
            drive,
            remarks,
        }
    }

    fn known(&mut self, columns: Columns, time: Nanos, message: &Message, truth: Truth) {
        let known = self
            .truths
            .entry(message.channel.topic.clone())
            .or_insert_with(|| Known {
                // Only the first of all values tells of nothing that was before it.
                before: (message.sequence > 1).then_some(truth),
                last: truth,
            });
        known.last = truth;
        if time < columns.from {
            known.before = Some(truth);
        }
    }

    fn at(&mut self, columns: Columns, time: Nanos, pose: Pose2D, winner: Option<usize>) {
        self.pose = Some(pose);
        if columns.has(time) {
            // What is no place is not drawn, and was not driven to.
            if is_placed(&[pose.x, pose.y]) {
                let from = self.place.replace(pose).unwrap_or(pose);
                self.distance += (pose.x - from.x).hypot(pose.y - from.y);
            }
            self.path.add(Moment {
                time: time as f64 / 1e9,
                x: pose.x,
                y: pose.y,
                heading: pose.theta,
                winner,
            });
        }
    }

    fn laser(&mut self, columns: Columns, time: Nanos, message: &Message) {
        let due = self.scanned.is_none_or(|last| time >= last + SCAN);
        let shows_walls = matches!(self.world, Some((_, Ok(_)))) && !self.topics.truths.is_empty();
        let (true, false, true, Some(robot)) = (due, shows_walls, columns.has(time), self.pose) else {
            return;
        };
        let Some(scan) = read::<LaserScan>(message) else {
            return;
        };
        self.scanned = Some(time);
        let seen = scan.ranges.iter().enumerate().filter(|(_, range)| {
            (scan.range_min..=scan.range_max).contains(*range) && **range < scan.range_max
        });
        let place = |(beam, range): (usize, &f32)| {
            let angle = f64::from(scan.angle_min) + beam as f64 * f64::from(scan.angle_increment);
            let (sin, cos) = angle.sin_cos();
            let range = f64::from(*range);
            let place = robot.transform(&Pose2D::new(range * cos, range * sin, 0.0));
            (place.x, place.y)
        };
        self.scans.add(seen.map(place).collect());
    }

    fn mission(&mut self, mission: Mission) {
        let place = (mission.target.x, mission.target.y);
        // A robot is never at a distance of 0 from where it has still to go.
        let is_place = place != (0.0, 0.0) || mission.distance > 0.0;
        if is_place && mission.reached < mission.total && self.found.len() < MOST_TARGETS {
            self.found.entry(mission.reached as usize).or_insert(place);
        }
        self.mission = Some(mission);
    }

    /// The targets, in the frame of the path; the route's where there is one.
    fn targets(&self) -> Vec<Target> {
        // Without any place the mission counts something else.
        if self.found.is_empty() {
            return Vec::new();
        }
        let reached = self.mission.map_or(0, |mission| mission.reached as usize);
        let target = |(before, (x, y)): (usize, (f64, f64))| {
            let (x, y) = match &self.anchor {
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

impl Known {
    fn collisions(&self) -> u64 {
        let before = self.before.map_or(0, |before| before.collisions);
        self.last.collisions.saturating_sub(before)
    }

    fn min_clearance(&self) -> Option<f64> {
        let least = self.last.min_clearance;
        let is_of_now = self.before.is_none_or(|before| least < before.min_clearance);
        (is_of_now && least.is_finite()).then_some(least)
    }
}

/// Of a file that others named, only what is a world is read.
fn load(path: &Path, seed: u64) -> Result<World, String> {
    match std::fs::metadata(path) {
        Ok(about) if !about.is_file() => Err("it is no file".to_owned()),
        Ok(_) => World::load(path, seed).map_err(|error| error.to_string()),
        Err(error) => Err(error.to_string()),
    }
}

impl Topics {
    fn of(recording: &Recording) -> Self {
        let all = |type_name: &str| {
            let of_type = recording
                .channels()
                .filter(|channel| channel.type_name == type_name && channel.encoding == "cdr");
            of_type.map(|channel| channel.topic.clone()).collect::<Vec<_>>()
        };
        let truths = all(&definition::name(&Truth::describe()));
        let owner = |topic: &str| topic.rsplit_once('/').map(|(owner, _)| owner.to_owned());
        // The robot that the truth is about, if it has one of these; else whoever has.
        let robot = truths.first().and_then(|topic| owner(topic));
        let of_robot = |type_name: &str| {
            let mut found = all(type_name);
            let own = found.iter().position(|topic| owner(topic) == robot).unwrap_or(0);
            (!found.is_empty()).then(|| found.swap_remove(own))
        };
        let mission = all(&definition::name(&Mission::describe())).into_iter().next();
        let of_mission = mission.as_deref().and_then(owner);
        let routes = all(&definition::name(&Route::describe()));
        let variable = |name: &str, unit: &str| {
            let mut fits = recording.channels().filter(|channel| {
                let said = |key: &str| channel.about.get(key).map_or("", String::as_str);
                said("access") == "modulation" && said("unit") == unit && said("variable").ends_with(name)
            });
            fits.next().cloned()
        };
        let world = variable(".world", "path");
        Self {
            odometry: of_robot(&definition::name(&Odometry::describe())),
            laser: of_robot(&definition::name(&LaserScan::describe())),
            route: routes.into_iter().find(|topic| owner(topic) == of_mission),
            radius: world.as_ref().and_then(|_| variable(".radius", "m")),
            world,
            mission,
            truths,
        }
    }
}

/// A message as the value of a type.
fn read<T: jde_types::Value>(message: &Message) -> Option<T> {
    let bytes = cdr::decode(&T::describe(), &message.data).ok()?;
    T::from_bytes(&bytes)
}

/// A message that is one number.
pub(super) fn number(message: &Message) -> Option<f64> {
    match single(&message.channel, message)? {
        Value::Float(number) => Some(number),
        Value::Int(number) => Some(number as f64),
        Value::UInt(number) => Some(number as f64),
        Value::Bool(_) | Value::Text(_) | Value::List(_) | Value::Map(_) => None,
    }
}

/// A message that is one text or number, of whatever type.
fn single(channel: &Channel, message: &Message) -> Option<Value> {
    let text = std::str::from_utf8(&channel.definition).ok()?;
    let value_type = definition::read(&channel.type_name, text).ok()?;
    let bytes = cdr::decode(&value_type, &message.data).ok()?;
    match value::decode(&value_type, &bytes) {
        Value::Map(mut fields) if fields.len() == 1 => Some(fields.remove(0).1),
        other => Some(other),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distance_and_takeovers_count_also_where_they_are_thinned() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("empty.mcap");
        crate::tests::recorder(&file, None).finish();
        let mut course = Course::new(&Recording::open(&file).unwrap());
        let columns = Columns::new(0, 1_000_000, 100);
        for step in 0..=100_000_u64 {
            course.at(columns, step, Pose2D::new((step % 2) as f64, 0.0, 0.0), None);
            course.took_over(0);
        }
        // Lost for a moment.
        course.at(columns, 100_001, Pose2D::new(f64::NAN, 0.0, 0.0), None);
        course.at(columns, 100_002, Pose2D::new(2.0, 0.0, 0.0), None);
        let ending = course.finish(String::new(), Vec::new(), Vec::new());
        assert!(ending.drive.path.len() <= MOST_PLACES && ending.drive.takeovers.len() <= MOST_TAKEOVERS);
        assert_eq!(
            (ending.distance, ending.drive.takeover_count),
            (Some(100_002.0), 100_001)
        );
    }
}
