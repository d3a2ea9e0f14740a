//! Feeds the drive of an application's run from its exports: where its robots are, their true poses, and its mission.
//!
//! It finds variables by type, whichever schema exports them, and writes none.

use jde_abi::describe::{Role, Type};
use jde_board::Reader;
use jde_core::Nanos;
use jde_host::Handle;
use jde_timeline::{DriveTimeline, Export, Hierarchy, RobotSources, Timeline};
use jde_types::{Body, LaserScan, Mission, Odometry, Route, Truth, Value};

/// Reads the exports of one application that show its progress.
pub(super) struct Sampler {
    /// The drive so far.
    pub(super) drive: DriveTimeline,
    /// The readers of each robot.
    readers: Vec<RobotReaders>,
    mission: Option<Reader>,
    /// A modulation of the mission's schema that contains its targets.
    route: Option<Reader>,
}

/// The readers of one robot.
struct RobotReaders {
    truth: Option<Reader>,
    odometry: Option<Reader>,
    laser: Option<Reader>,
    body: Option<Reader>,
}

impl Sampler {
    /// Finds the exports to read: the poses of every robot, and the mission. `has_scans` is whether to keep what lasers see,
    /// which replaces a missing world.
    pub(super) fn new(handle: &Handle, has_scans: bool) -> Self {
        let application = handle.application();
        let reader = |name: &str| Some(handle.board().find(name)?.reader("jde"));
        let exports = |value_type: &Type| Export::of_application(application, value_type);
        let hierarchy = Hierarchy::of_application(application);
        let is_commanded = |robot: &str| {
            let mut commanded = hierarchy.schemas().iter().flat_map(|schema| &schema.commands);
            commanded.any(|commanded| commanded == robot)
        };
        let (robots, _) = RobotSources::find(exports, is_commanded);
        let readers = robots.iter().map(|robot| RobotReaders {
            truth: robot.truth.as_deref().and_then(reader),
            odometry: robot.odometry.as_deref().and_then(reader),
            laser: robot.laser.as_deref().filter(|_| has_scans).and_then(reader),
            body: robot.body.as_deref().and_then(reader),
        });
        let readers = readers.collect();
        let leader = application
            .mission
            .map(|mission| &application.instances[mission.instance]);
        let route = Route::describe().name;
        let route = leader.and_then(|leader| {
            let mut ports = leader.schema.ports.iter();
            let port = ports
                .find(|port| matches!(port.role, Role::Modulation { .. }) && port.value_type.name == route)?;
            reader(&format!("{}.{}", leader.name, port.name))
        });
        let mission = application.mission;
        let mission = mission.and_then(|port| reader(&application.variable_name(port)));
        Self {
            drive: DriveTimeline::new(robots, leader.map(|leader| leader.name.clone()), 0),
            readers,
            mission,
            route,
        }
    }

    /// Reads the values that are valid now.
    pub(super) fn sample(&mut self, now: Nanos, timeline: &Timeline) {
        let is_alone = self.drive.is_alone();
        for (robot, readers) in self.drive.robots.iter_mut().zip(&mut self.readers) {
            let name = robot.sources.name.clone();
            let acting = || DriveTimeline::acting_for(&name, is_alone, timeline);
            if robot.body.is_none() {
                robot.body = read::<Body>(&mut readers.body, now);
            }
            if let Some(truth) = read::<Truth>(&mut readers.truth, now) {
                robot.add_truth(now, truth, true, acting);
            }
            if let Some(odometry) = read::<Odometry>(&mut readers.odometry, now) {
                robot.add_odometry(now, &odometry, acting);
            }
            if robot.wants_scan(now)
                && let Some(scan) = read::<LaserScan>(&mut readers.laser, now)
            {
                robot.add_scan(now, &scan);
            }
        }
        self.drive.mission.add(read::<Mission>(&mut self.mission, now));
        if let Some(route) = read::<Route>(&mut self.route, now) {
            self.drive.mission.set_route(&route);
        }
    }
}

/// Reads the value of a variable that is valid now, and releases it. `None` also if another type has this name.
fn read<T: Value>(reader: &mut Option<Reader>, now: Nanos) -> Option<T> {
    let reader = reader.as_mut()?;
    let value = reader.latch(now).and_then(|latched| T::from_bytes(latched.bytes));
    reader.release();
    value
}
