//! What can be seen of a running application from its exports: the robot's place, the truth about it, its mission.
//!
//! It reads variables by their types, whoever exports them, and writes none.

use jde_abi::describe::{Port, Role, Type};
use jde_board::Reader;
use jde_board::value::{self, Value};
use jde_host::Handle;
use jde_types::{LaserScan, Odometry, Pose2D, Quaternion, Route, Truth, Value as _};

/// Reads the exports of one application that tell how it goes.
pub(crate) struct Sight {
    truths: Vec<Reader>,
    odometry: Option<Reader>,
    mission: Option<Reader>,
    /// A modulation of whoever has the mission, in which its targets are named.
    route: Option<Reader>,
    laser: Option<Reader>,
    /// Whether any target so far was a place.
    places: bool,
    /// The same place in the frame of the truth and of the odometry, seen first.
    anchor: Option<(Pose2D, Pose2D)>,
}

/// What was seen at one instant.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Seen {
    /// Where the robot truly is, in the world.
    pub(crate) truth: Option<Pose2D>,
    /// Where it believes to be.
    pub(crate) odometry: Option<Pose2D>,
    /// Contacts of all robots so far; none without ground truth.
    pub(crate) collisions: Option<u64>,
    /// The least gap to anything so far, of all robots, m.
    pub(crate) min_clearance: Option<f64>,
    /// How far the mission is.
    pub(crate) mission: Option<Progress>,
}

/// How far a mission is.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Progress {
    /// Targets reached.
    pub(crate) reached: u32,
    /// Targets in all; 0 if it goes on for ever.
    pub(crate) total: u32,
    /// The present target, in the frame of the odometry; none if it is none, or no place.
    pub(crate) target: Option<(f64, f64)>,
    /// Whether any target so far was a place; else the note says what is counted.
    pub(crate) of_places: bool,
    /// Its own words.
    pub(crate) note: String,
}

impl Sight {
    /// Finds the exports to read. Of several robots the first is followed, and all count for collisions.
    pub(crate) fn new(handle: &Handle) -> Self {
        let application = handle.application();
        let exports = |name: &str| -> Vec<(usize, Reader)> {
            let mut found = Vec::new();
            for (number, instance) in application.instances.iter().enumerate() {
                let ports = instance.schema.ports.iter();
                for port in ports.filter(|port| port.role == Role::Export && port.value_type.name == name) {
                    let variable = handle.board().find(&format!("{}.{}", instance.name, port.name));
                    found.extend(variable.map(|variable| (number, variable.reader("jde"))));
                }
            }
            found
        };
        let truths = exports(&Truth::describe().name);
        let robot = truths.first().map(|(robot, _)| *robot);
        // The robot that the truth is about, if it has one of these; else whoever has.
        let of_robot = |name: &str| {
            let mut found = exports(name);
            let own = found
                .iter()
                .position(|(number, _)| Some(*number) == robot)
                .unwrap_or(0);
            (!found.is_empty()).then(|| found.swap_remove(own).1)
        };
        let of_mission = |wanted: &dyn Fn(usize, &Port) -> bool| {
            let instance = &application.instances[application.mission?.0];
            let mut ports = instance.schema.ports.iter().enumerate();
            let (_, port) = ports.find(|(number, port)| wanted(*number, port))?;
            let name = format!("{}.{}", instance.name, port.name);
            Some(handle.board().find(&name)?.reader("jde"))
        };
        let route = Route::describe().name;
        Self {
            odometry: of_robot(&Odometry::describe().name),
            laser: of_robot(&LaserScan::describe().name),
            truths: truths.into_iter().map(|(_, reader)| reader).collect(),
            mission: of_mission(&|number, _| application.mission.is_some_and(|(_, port)| port == number)),
            route: of_mission(&|_, port| {
                matches!(port.role, Role::Modulation { .. }) && port.value_type.name == route
            }),
            places: false,
            anchor: None,
        }
    }

    /// Looks.
    pub(crate) fn look(&mut self) -> Seen {
        let mut seen = Seen::default();
        for truth in &mut self.truths {
            let _ = read(truth, |read| {
                let pose = read.pose("pose")?;
                seen.truth.get_or_insert(pose);
                *seen.collisions.get_or_insert(0) += read.number("collisions")? as u64;
                let least = seen.min_clearance.get_or_insert(f64::INFINITY);
                *least = least.min(read.number("min_clearance")?);
                Some(())
            });
        }
        seen.odometry = self
            .odometry
            .as_mut()
            .and_then(|odometry| read(odometry, |read| read.odometry()));
        seen.mission = self
            .mission
            .as_mut()
            .and_then(|mission| read(mission, Progress::read));
        if let Some(mission) = &mut seen.mission {
            self.places |= mission.of_places;
            mission.of_places = self.places;
        }
        if let (None, Some(truth), Some(odometry)) = (self.anchor, seen.truth, seen.odometry) {
            self.anchor = Some((truth, odometry));
        }
        seen
    }

    /// A place given in the frame of the odometry, in the frame of the path: the world's where there is ground truth.
    pub(crate) fn in_path(&self, (x, y): (f64, f64)) -> (f64, f64) {
        let Some((truth, odometry)) = &self.anchor else {
            return (x, y);
        };
        let place = truth.transform(&odometry.localize(&Pose2D::new(x, y, 0.0)));
        (place.x, place.y)
    }

    /// The targets that the mission is going to have, in the frame of the path, as far as it tells.
    pub(crate) fn route(&mut self) -> Vec<(f64, f64)> {
        let poses = self.route.as_mut().and_then(|route| {
            read(route, |read| {
                let Value::List(poses) = read.value("poses")? else {
                    return None;
                };
                let place = |number: usize| {
                    let part = |name: &str| read.number(&format!("poses[{number}].{name}"));
                    Some((part("x")?, part("y")?))
                };
                (0..poses.len()).map(place).collect::<Option<Vec<_>>>()
            })
        });
        let poses = poses.unwrap_or_default().into_iter();
        poses.map(|place| self.in_path(place)).collect()
    }

    /// Places that the laser sees now, in the frame of the path, taking the laser to be where the robot is.
    pub(crate) fn scan(&mut self, robot: Pose2D) -> Vec<(f64, f64)> {
        let points = self.laser.as_mut().and_then(|laser| {
            read(laser, |read| {
                let (first, step) = (read.number("angle_min")?, read.number("angle_increment")?);
                let valid = read.number("range_min")?..=read.number("range_max")?;
                let Value::List(ranges) = read.value("ranges")? else {
                    return None;
                };
                let ranges = ranges.iter().filter_map(number).enumerate();
                let valid = ranges.filter(|(_, range)| valid.contains(range));
                let place = |(beam, range): (usize, f64)| {
                    let (sin, cos) = (first + beam as f64 * step).sin_cos();
                    let place = robot.transform(&Pose2D::new(range * cos, range * sin, 0.0));
                    (place.x, place.y)
                };
                Some(valid.map(place).collect())
            })
        });
        points.unwrap_or_default()
    }
}

impl Progress {
    /// Of a value of type `Mission`.
    pub(crate) fn read(read: Read<'_>) -> Option<Self> {
        let note = match read.value("note")? {
            Value::Text(note) => note,
            _ => String::new(),
        };
        // A robot is never at a distance of 0 from where it has still to go.
        let target = (read.number("target.x")?, read.number("target.y")?);
        let target = (target != (0.0, 0.0) || read.number("distance")? > 0.0).then_some(target);
        Some(Self {
            reached: read.number("reached")? as u32,
            total: read.number("total")? as u32,
            target,
            of_places: target.is_some(),
            note,
        })
    }
}

/// A value being looked at.
#[derive(Clone, Copy)]
pub(crate) struct Read<'v> {
    pub(crate) value_type: &'v Type,
    pub(crate) bytes: &'v [u8],
}

impl Read<'_> {
    fn value(self, path: &str) -> Option<Value> {
        value::get_path(self.value_type, self.bytes, path).ok()
    }

    fn number(self, path: &str) -> Option<f64> {
        number(&self.value(path)?)
    }

    /// The pose of a value of type `Odometry`.
    pub(crate) fn odometry(self) -> Option<Pose2D> {
        let part = |name: &str| self.number(&format!("pose.pose.orientation.{name}"));
        let turned = Quaternion {
            x: part("x")?,
            y: part("y")?,
            z: part("z")?,
            w: part("w")?,
        };
        let place = |name: &str| self.number(&format!("pose.pose.position.{name}"));
        Some(Pose2D::new(place("x")?, place("y")?, turned.yaw()))
    }

    fn pose(self, path: &str) -> Option<Pose2D> {
        let part = |name: &str| self.number(&format!("{path}.{name}"));
        Some(Pose2D::new(part("x")?, part("y")?, part("theta")?))
    }
}

/// Looks at the newest value of a variable, and lets go of it.
fn read<T>(reader: &mut Reader, look: impl FnOnce(Read<'_>) -> Option<T>) -> Option<T> {
    let value_type = reader.variable().describe().value_type.clone();
    let result = reader.latch().and_then(|latched| {
        look(Read {
            value_type: &value_type,
            bytes: latched.bytes,
        })
    });
    reader.release();
    result
}

fn number(value: &Value) -> Option<f64> {
    match value {
        Value::Float(number) => Some(*number),
        Value::Int(number) => Some(*number as f64),
        Value::UInt(number) => Some(*number as f64),
        Value::Bool(_) | Value::Text(_) | Value::List(_) | Value::Map(_) => None,
    }
}
