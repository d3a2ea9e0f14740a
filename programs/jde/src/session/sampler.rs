//! Reads from an application's exports where its robots are, their true poses, and its mission.
//!
//! It finds variables by type, whichever schema exports them, and writes none.

use std::collections::BTreeMap;

use jde_abi::describe::{Port, Role};
use jde_app::{Application, Binding};
use jde_board::Reader;
use jde_core::Nanos;
use jde_host::Handle;
use jde_types::{LaserScan, Mission, Odometry, Pose2D, Route, Truth, Value as _};

/// Reads the exports of one application that show its progress.
pub(crate) struct Sampler {
    robots: Vec<RobotReaders>,
    /// The index of the robot that the mission is about.
    mission_robot: usize,
    /// The drivers that each schema commands.
    commands: BTreeMap<usize, Vec<usize>>,
    mission: Option<Reader>,
    /// A modulation of the mission's schema that contains its targets.
    route: Option<Reader>,
    /// Whether any target so far was a position.
    has_position_targets: bool,
}

/// One robot.
struct RobotReaders {
    /// The driver's index in the application.
    instance: usize,
    truth: Option<Reader>,
    odometry: Option<Reader>,
    laser: Option<Reader>,
    /// The pose first seen, in the frames of the truth and of the odometry.
    anchor: Option<(Pose2D, Pose2D)>,
}

/// The values at one instant.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Observation {
    /// The true pose in the world; with several robots, of the one that the mission is about.
    pub(crate) truth: Option<Pose2D>,
    /// The same robot's pose by its odometry.
    pub(crate) odometry: Option<Pose2D>,
    /// The pose of each robot, by its driver's index in the application: in the world, or in the frame of its
    /// odometry where there is no ground truth.
    pub(crate) poses: Vec<(usize, Pose2D)>,
    /// Contacts of all robots so far; `None` without ground truth.
    pub(crate) collisions: Option<u64>,
    /// The least distance of any robot to an obstacle so far, m; `None` without ground truth.
    pub(crate) min_clearance: Option<f64>,
    /// The progress of the mission.
    pub(crate) mission: Option<MissionProgress>,
}

/// The progress of a mission.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct MissionProgress {
    /// Targets reached.
    pub(crate) reached: u32,
    /// Targets in total; 0 for a mission without end.
    pub(crate) total: u32,
    /// The present target, in the frame of the odometry; `None` if there is none, or if it is not a position.
    pub(crate) target: Option<(f64, f64)>,
    /// Whether any target so far was a position; if not, the note names what is counted.
    pub(crate) counts_positions: bool,
    /// The mission's own text.
    pub(crate) note: String,
}

impl Sampler {
    /// Finds the exports to read: the poses of every robot, and the mission.
    pub(crate) fn new(handle: &Handle) -> Self {
        let application = handle.application();
        let exports = |name: &str| -> Vec<(usize, Reader)> {
            let mut found = Vec::new();
            for (number, instance) in application.instances.iter().enumerate() {
                let ports = instance.schema.ports.iter();
                for port in ports
                    .filter(|port| matches!(port.role, Role::Export { .. }) && port.value_type.name == name)
                {
                    let variable = handle.board().find(&format!("{}.{}", instance.name, port.name));
                    found.extend(variable.map(|variable| (number, variable.reader("jde"))));
                }
            }
            found
        };
        let [mut truths, mut odometries, mut lasers] =
            [Truth::describe(), Odometry::describe(), LaserScan::describe()].map(|of| exports(&of.name));
        let numbers =
            |readers: &[(usize, Reader)]| readers.iter().map(|(number, _)| *number).collect::<Vec<_>>();
        let commands = commands(application);
        // Schemas that correct odometry export it too, so the robots are the instances that are commanded. If
        // none is commanded, the first counts as the only robot.
        let mut robots = numbers(if truths.is_empty() { &odometries } else { &truths });
        if robots
            .iter()
            .any(|robot| commands.values().any(|of| of.contains(robot)))
        {
            robots.retain(|robot| commands.values().any(|of| of.contains(robot)));
        } else {
            robots.truncate(1);
        }
        robots.dedup();
        let single = robots.len() == 1;
        // The robot's own export. A single robot may use the export of any schema.
        let of = |robot: usize, readers: &mut Vec<(usize, Reader)>| {
            let own = readers.iter().position(|(number, _)| *number == robot);
            let index = own.or((single && !readers.is_empty()).then_some(0))?;
            Some(readers.swap_remove(index).1)
        };
        let robots = robots.into_iter().map(|instance| RobotReaders {
            instance,
            truth: of(instance, &mut truths),
            odometry: of(instance, &mut odometries),
            laser: of(instance, &mut lasers),
            anchor: None,
        });
        let robots: Vec<RobotReaders> = robots.collect();
        let mission_robot = application.mission.and_then(|(leader, _)| {
            let below = |schema: usize| {
                let mut fathers = std::iter::successors(Some(schema), |at| application.instances[*at].father);
                fathers.any(|father| father == leader)
            };
            let mut known = commands.iter().filter(|(schema, _)| below(**schema));
            let robot = known.find_map(|(_, of)| of.first())?;
            robots.iter().position(|readers| readers.instance == *robot)
        });
        let of_mission = |is_match: &dyn Fn(usize, &Port) -> bool| {
            let instance = &application.instances[application.mission?.0];
            let mut ports = instance.schema.ports.iter().enumerate();
            let (_, port) = ports.find(|(number, port)| is_match(*number, port))?;
            let name = format!("{}.{}", instance.name, port.name);
            Some(handle.board().find(&name)?.reader("jde"))
        };
        let route = Route::describe().name;
        Self {
            robots,
            mission_robot: mission_robot.unwrap_or(0),
            commands,
            mission: of_mission(&|number, _| application.mission.is_some_and(|(_, port)| port == number)),
            route: of_mission(&|_, port| {
                matches!(port.role, Role::Modulation { .. }) && port.value_type.name == route
            }),
            has_position_targets: false,
        }
    }

    /// Returns the schema among `acting` that acts for a robot, given its driver's index in the application.
    pub(crate) fn find_actor(&self, robot: usize, acting: &[usize]) -> Option<usize> {
        let mut acting = acting.iter().copied();
        acting.find(|schema| self.robots_of(*schema).any(|of| of == robot))
    }

    /// Returns the robots that a schema acts for. With a single robot, every schema acts for it.
    pub(crate) fn robots_of(&self, schema: usize) -> impl Iterator<Item = usize> + '_ {
        let single = self.robots.len() == 1;
        let robots = self.robots.iter().map(|robot| robot.instance);
        robots.filter(move |robot| single || self.commands.get(&schema).is_some_and(|of| of.contains(robot)))
    }

    /// Reads the values that are valid now.
    pub(crate) fn sample(&mut self, now: Nanos) -> Observation {
        let mut observation = Observation::default();
        for (number, robot) in self.robots.iter_mut().enumerate() {
            let truth = robot
                .truth
                .as_mut()
                .and_then(|reader| read::<Truth>(reader, now))
                .map(|truth| {
                    *observation.collisions.get_or_insert(0) += truth.collisions;
                    let least = observation.min_clearance.get_or_insert(f64::INFINITY);
                    *least = least.min(truth.min_clearance);
                    truth.pose
                });
            let odometry = robot
                .odometry
                .as_mut()
                .and_then(|reader| read::<Odometry>(reader, now));
            let odometry = odometry.map(|odometry| odometry.pose2d());
            if let (None, Some(truth), Some(odometry)) = (robot.anchor, truth, odometry) {
                robot.anchor = Some((truth, odometry));
            }
            if number == self.mission_robot {
                (observation.truth, observation.odometry) = (truth, odometry);
            }
            observation
                .poses
                .extend(truth.or(odometry).map(|pose| (robot.instance, pose)));
        }
        let mission = self
            .mission
            .as_mut()
            .and_then(|reader| read::<Mission>(reader, now));
        observation.mission = mission.map(|mission| MissionProgress::of(&mission));
        if let Some(mission) = &mut observation.mission {
            self.has_position_targets |= mission.counts_positions;
            mission.counts_positions = self.has_position_targets;
        }
        observation
    }

    /// Converts a position from the frame of the odometry to that of the path, which is the world where there
    /// is ground truth.
    pub(crate) fn to_path_frame(&self, (x, y): (f64, f64)) -> (f64, f64) {
        let anchor = self
            .robots
            .get(self.mission_robot)
            .and_then(|robot| robot.anchor.as_ref());
        let Some((truth, odometry)) = anchor else {
            return (x, y);
        };
        let point = truth.transform(&odometry.localize(&Pose2D::new(x, y, 0.0)));
        (point.x, point.y)
    }

    /// Returns the targets that the mission names in advance, in the frame of the path.
    pub(crate) fn route(&mut self) -> Vec<(f64, f64)> {
        let route = self
            .route
            .as_mut()
            .and_then(|reader| read::<Route>(reader, 0))
            .unwrap_or_default();
        let poses = route.poses.iter();
        poses.map(|pose| self.to_path_frame((pose.x, pose.y))).collect()
    }

    /// Returns the points that a robot's laser sees now, in the frame of the path. The laser is taken to be
    /// at the robot's pose.
    pub(crate) fn scan(&mut self, instance: usize, robot: Pose2D, now: Nanos) -> Vec<(f64, f64)> {
        let mut robots = self.robots.iter_mut();
        let laser = robots
            .find(|robot| robot.instance == instance)
            .and_then(|robot| robot.laser.as_mut());
        let scan = laser.and_then(|reader| read::<LaserScan>(reader, now));
        let points = scan.iter().flat_map(LaserScan::points);
        let points = points.map(|point| robot.transform(&Pose2D::new(point.x, point.y, 0.0)));
        points.map(|point| (point.x, point.y)).collect()
    }
}

impl MissionProgress {
    /// Returns what is shown of a mission.
    pub(crate) fn of(mission: &Mission) -> Self {
        // A robot that has still to travel is at a distance above 0, so (0, 0) at a distance of 0 means no
        // target.
        let target = (mission.target.x, mission.target.y);
        let target = (target != (0.0, 0.0) || mission.distance > 0.0).then_some(target);
        Self {
            reached: mission.reached,
            total: mission.total,
            target,
            counts_positions: target.is_some(),
            note: mission.note.to_string(),
        }
    }
}

/// Returns the drivers that each schema commands, by their indices in an application.
fn commands(application: &Application) -> BTreeMap<usize, Vec<usize>> {
    let instances = application.instances.iter().enumerate();
    let targets = instances.map(|(number, instance)| {
        let targets = instance.bindings.iter().filter_map(|binding| match binding {
            Binding::Actuator { target } => target.map(|(driver, _)| driver),
            _ => None,
        });
        (number, targets.collect::<Vec<_>>())
    });
    targets.filter(|(_, drivers)| !drivers.is_empty()).collect()
}

/// Reads the value of a variable that is valid now, and releases it. `None` also if another type has this name.
fn read<T: jde_types::Value>(reader: &mut Reader, now: Nanos) -> Option<T> {
    let value = reader.latch(now).and_then(|latched| T::from_bytes(latched.bytes));
    reader.release();
    value
}
