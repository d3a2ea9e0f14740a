//! How a robot enters its world, and what its driver keeps while it is there.

use core::time::Duration;

use jde_motion::Setpoint;
use jde_schema::prelude::*;
use jde_sim::{Pose2, RobotConfig, RobotId, RobotModel, World, WorldError};

use crate::Robot;
use crate::edits::EditCount;
use crate::output::Output;
use crate::worlds::RobotClaim;

/// The world, and how a robot enters it.
pub(crate) struct Entry {
    path: Text<1024>,
    name: String,
    /// Instead of its start in the world file.
    start: Option<Pose2>,
}

/// A robot in a world.
pub(crate) struct ActiveRobot {
    pub(crate) claim: RobotClaim,
    pub(crate) model: RobotModel,
    /// Time at which it entered its world.
    pub(crate) since: Duration,
    /// The count of changes of the world when its static objects were published; `None` before that.
    pub(crate) scenery: Option<u64>,
    /// The edits that were published last.
    pub(crate) edits: Option<EditCount>,
    pub(crate) due: Due,
    pub(crate) setpoint: Setpoint,
    /// The contacts that the log has.
    pub(crate) contacts: u64,
}

/// When exports are due next, and what is on its way to them.
#[derive(Default)]
pub(crate) struct Due {
    pub(crate) movers: Option<Duration>,
    pub(crate) laser: Output<LaserScan>,
    pub(crate) sonars: Output<RangeRing>,
    pub(crate) line_sensor: Output<LineSensor>,
    pub(crate) imu: Output<Imu>,
    pub(crate) position: Output<PositionFix>,
    pub(crate) odometry: Output<Odometry>,
    pub(crate) encoders: Output<WheelEncoders>,
}

impl Entry {
    /// Returns what the modulations of a driver say.
    pub(crate) fn new(cx: &Context, driver: &Robot) -> Self {
        let named = driver.robot.get(cx);
        let name = if named.is_empty() {
            cx.name()
        } else {
            named.as_str()
        };
        let start = driver.start.get(cx);
        Self {
            path: driver.world.get(cx),
            name: name.to_owned(),
            start: (start.pose.first()).map(|pose| Pose2::new(pose.x, pose.y, pose.theta)),
        }
    }

    /// Returns the path of the world file.
    pub(crate) fn path(&self) -> Result<&str> {
        if self.path.is_empty() {
            return Err(
                "it has no world; give it one in the application: world = \"worlds/office.toml\"".into(),
            );
        }
        Ok(self.path.as_str())
    }

    /// Returns its robot. One that is not in the world is added: at its start, or at that of the file.
    pub(crate) fn find_or_add(&self, world: &mut World, config: RobotConfig) -> Result<RobotId, WorldError> {
        let present = world.robots().find(|(_, known)| *known == self.name);
        match (present.map(|(robot, _)| robot), self.start) {
            (Some(robot), _) => Ok(robot),
            (None, Some(start)) => world.add_robot_at(&self.name, start, config),
            (None, None) => world.add_robot(&self.name, config),
        }
    }
}

impl ActiveRobot {
    /// Places the robot at its start.
    pub(crate) fn enter(cx: &Context, entry: Entry, model: RobotModel) -> Result<Self> {
        let key = (cx.application(), entry.path()?, cx.seed());
        let claim = RobotClaim::acquire(key, model.lasers.clone(), |world| {
            entry.find_or_add(world, model.config.clone())
        })?;
        // A robot that an earlier driver left in the world may have touched something then.
        let contacts = claim.world().truth(claim.robot()).collisions;
        Ok(Self {
            claim,
            model,
            since: cx.now(),
            scenery: None,
            edits: None,
            due: Due::default(),
            setpoint: Setpoint::default(),
            contacts,
        })
    }

    /// Stops the robot. What is on its way to readers does not arrive.
    pub(crate) fn stop(&mut self) {
        self.claim.stop();
        self.setpoint = Setpoint::default();
        let due = &mut self.due;
        due.laser.clear();
        due.sonars.clear();
        due.line_sensor.clear();
        due.imu.clear();
        due.position.clear();
        due.odometry.clear();
        due.encoders.clear();
    }
}
