//! What the drivers of robots have in common: a robot in a world, and the ports that steer and show it.

use core::time::Duration;

use jde_schema::prelude::*;
use jde_schema::types::{Movers, Scenery};
use jde_sim::{HeadCommand, Pose2, RobotConfig, RobotId, RobotModel, Twist2, World, WorldError};

use crate::Start;
use crate::edits::EditCount;
use crate::scenery::{self, PUBLISH_PERIOD};
use crate::worlds::RobotClaim;

/// The ports of a robot's driver.
pub(crate) struct Ports<'a> {
    pub(crate) edit: &'a Modulation<Text<4096>>,
    pub(crate) velocity: &'a Command<Twist>,
    pub(crate) head: &'a Command<PanTilt>,
    pub(crate) laser: &'a mut Export<LaserScan>,
    pub(crate) sonars: &'a mut Export<RangeRing>,
    pub(crate) line_sensor: &'a mut Export<LineSensor>,
    pub(crate) imu: &'a mut Export<Imu>,
    pub(crate) position: &'a mut Export<PositionFix>,
    pub(crate) odometry: &'a mut Export<Odometry>,
    pub(crate) bumpers: &'a mut Export<Bumpers>,
    pub(crate) pan_tilt: &'a mut Export<PanTilt>,
    pub(crate) battery: &'a mut Export<BatteryState>,
    pub(crate) encoders: &'a mut Export<WheelEncoders>,
    pub(crate) connection: &'a mut Export<Connection>,
    pub(crate) truth: &'a mut Export<Truth>,
    pub(crate) scenery: &'a mut Export<Scenery>,
    pub(crate) movers: &'a mut Export<Movers>,
    pub(crate) edits: &'a mut Export<EditCount>,
}

/// The world, and how a robot enters it.
pub(crate) struct Entry {
    path: Text<1024>,
    name: String,
    /// Instead of its start in the world file.
    start: Option<Pose2>,
}

/// A robot in a world.
pub(crate) struct ActiveRobot {
    claim: RobotClaim,
    model: RobotModel,
    /// Time at which it entered its world.
    since: Duration,
    /// The count of changes of the world when its static objects were published; `None` before that.
    scenery: Option<u64>,
    /// The edits that were published last.
    edits: Option<EditCount>,
    due: Due,
}

/// The times at which exports are due next; `None` before the first time.
#[derive(Default)]
pub(crate) struct Due {
    pub(crate) movers: Option<Duration>,
    pub(crate) laser: Option<Duration>,
    pub(crate) sonars: Option<Duration>,
    pub(crate) line_sensor: Option<Duration>,
    pub(crate) imu: Option<Duration>,
    pub(crate) position: Option<Duration>,
}

impl Entry {
    pub(crate) fn new(
        cx: &Context,
        world: &Modulation<Text<1024>>,
        robot: &Modulation<Text<60>>,
        start: &Modulation<Start>,
    ) -> Self {
        let named = robot.get(cx);
        let name = if named.is_empty() {
            cx.name()
        } else {
            named.as_str()
        };
        let start = start.get(cx);
        Self {
            path: world.get(cx),
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
        Ok(Self {
            claim,
            model,
            since: cx.now(),
            scenery: None,
            edits: None,
            due: Due::default(),
        })
    }

    /// Stops the robot.
    pub(crate) fn stop(&self) {
        self.claim.stop();
    }
}

impl Ports<'_> {
    /// Steps the world to the present time, commands the robot and publishes what it senses.
    pub(crate) fn iterate(&mut self, cx: &Context, active: &mut ActiveRobot) -> Result {
        let twist = *self.velocity.get(cx).value();
        let head = *self.head.get(cx).value();
        let robot = active.claim.robot();
        let mut world = active.claim.world();
        // Up to now the last command applies; the new one applies from now on.
        world.advance_to(cx.now().as_nanos() as u64);
        let twist = Twist2 {
            linear: twist.linear.x,
            lateral: twist.linear.y,
            angular: twist.angular.z,
        };
        world.command(robot, twist)?;
        let head = HeadCommand {
            pan: head.pan,
            tilt: head.tilt,
            pan_speed: head.pan_velocity,
            tilt_speed: head.tilt_velocity,
        };
        world.command_head(robot, head)?;
        let edits = self.edit(cx, &mut world, &active.claim);
        if active.edits.replace(edits) != Some(edits) {
            self.edits.write(cx, edits);
        }
        self.sense(cx, &world, robot, &active.model, &mut active.due)?;
        self.publish_connection(cx, &world, active.since);
        if active.scenery.replace(world.changes()) != Some(world.changes()) {
            self.publish_scenery(cx, &world);
        }
        if scenery::is_time(&mut active.due.movers, cx.now(), PUBLISH_PERIOD) {
            self.publish_movers(cx, &world, robot);
        }
        Ok(())
    }
}
