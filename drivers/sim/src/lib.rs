//! A simulated Pioneer and its cameras as drivers: the library `jde-sim` behind the ports of a robot. The
//! robot steps the world to the application's time. The drivers depend on no schedule and on no other schema.

mod camera;
mod edits;
mod scenery;
mod sense;
mod worlds;

use core::time::Duration;

use jde_schema::prelude::*;
use jde_schema::types::{Movers, Scenery};
use jde_sim::{
    Footprint, HeadCommand, LaserConfig, OdometryOrigin, Pose2, RobotConfig, RobotId, SonarConfig, Twist2,
    World, WorldError,
};

pub use camera::Camera;
pub use edits::EditCount;
use worlds::RobotClaim;

/// A head command that holds both axes.
const HOLD: PanTilt = PanTilt {
    header: Header {
        stamp: Time { sec: 0, nanosec: 0 },
        frame_id: Text::EMPTY,
    },
    pan: 0.0,
    tilt: 0.0,
    pan_velocity: 0.0,
    tilt_velocity: 0.0,
};

/// Where a robot starts, if not at the start of the world file.
#[derive(Clone, Copy, Debug, Default, PartialEq, Value)]
#[repr(C)]
#[value(name = "jde_msgs/msg/Start")]
pub struct Start {
    /// The pose in the frame of the world; none for that of the file.
    pub pose: Seq<Pose2D, 1>,
}

/// A Pioneer P3-DX with a laser in a simulated world. Several in one application share the world.
///
/// Frames by REP-105: the odometry starts at the robot's start pose in the world, so that `odom` equals the
/// world's frame except for the drift of the wheels.
#[derive(Describe)]
#[schema(driver, period = "50ms", budget = "50ms")]
pub struct Pioneer {
    /// The world file.
    #[modulation(default = "", unit = "file", fixed)]
    world: Modulation<Text<1024>>,
    /// The robot's name in the world file; empty for the name of this schema.
    #[modulation(default = "", fixed)]
    robot: Modulation<Text<60>>,
    /// Where it starts instead of at its start in the world file: `[{ x = 1.0, y = 2.0, theta = "90 deg" }]`.
    #[modulation(default = Start { pose: Seq::new() }, fixed)]
    start: Modulation<Start>,
    /// Changes of the world while it runs. Each write takes effect once, at the next iteration.
    #[modulation(default = "")]
    edit: Modulation<Text<4096>>,
    /// Beams of the laser.
    #[modulation(default = 180, min = 1, max = 1088, fixed)]
    laser_beams: Modulation<u32>,
    /// The angle that the laser covers, centred ahead.
    #[modulation(default = core::f64::consts::PI, unit = "rad", min = 0.01, max = core::f64::consts::TAU, fixed)]
    laser_view: Modulation<f64>,
    /// Greatest range of the laser.
    #[modulation(default = 8.0, unit = "m", min = 0.1, fixed)]
    laser_range: Modulation<f64>,
    /// Standard deviation of the laser's ranges.
    #[modulation(default = 0.005, unit = "m", min = 0.0, fixed)]
    laser_noise: Modulation<f64>,
    /// Standard deviation of the sonars' ranges.
    #[modulation(default = 0.01, unit = "m", min = 0.0, fixed)]
    sonar_noise: Modulation<f64>,
    /// Standard deviation of each wheel's scale error, as a fraction. It determines the drift of the
    /// odometry.
    #[modulation(default = 0.0002, min = 0.0, max = 0.5, fixed)]
    wheel_error: Modulation<f64>,
    /// Greatest change of speed per second.
    #[modulation(default = 0.3, unit = "m/s2", min = 0.01, fixed)]
    acceleration: Modulation<f64>,
    /// Radius of the body.
    #[modulation(default = 0.25, unit = "m", min = 0.01, max = 10.0, fixed)]
    radius: Modulation<f64>,
    /// Speeds of the base.
    #[command(neutral = Twist::ZERO, validity = "500ms")]
    velocity: Command<Twist>,
    /// Position of the pan-tilt head, and its speeds, whose signs are ignored; a speed of 0 holds its axis.
    /// Without a new command the head continues to the last position and stays there, so a command is valid
    /// for an hour.
    #[command(neutral = HOLD, validity = "3600s")]
    head: Command<PanTilt>,
    /// The scan of the laser, in its own frame, 18 mm ahead of the base.
    #[export]
    laser: Export<LaserScan>,
    /// The sixteen sonars: eight ahead from left to right, then eight behind from right to left.
    #[export]
    sonars: Export<RangeRing>,
    /// Pose and velocity from the wheels.
    #[export]
    odometry: Export<Odometry>,
    /// Five bumpers ahead, five behind, and whether the wheels are blocked.
    #[export]
    bumpers: Export<Bumpers>,
    /// Position and speed of the head.
    #[export]
    pan_tilt: Export<PanTilt>,
    /// Voltage, current and charge of the three lead-acid blocks.
    #[export]
    battery: Export<BatteryState>,
    /// The counts of the wheels.
    #[export]
    encoders: Export<WheelEncoders>,
    /// Always connected. Its stamp is the time at which the robot entered its world, and its note names the
    /// world.
    #[export]
    connection: Export<Connection>,
    /// The true state of the robot, for measurements. A schema that steers by it would work only in the
    /// simulator.
    #[export]
    truth: Export<Truth>,
    /// The static objects of the world, published when the robot enters it and when they change; for windows.
    /// No robot has such a sensor.
    #[export]
    scenery: Export<Scenery>,
    /// The objects that move or can be moved, ten times per second; for windows. No robot has such a sensor.
    #[export]
    movers: Export<Movers>,
    /// The changes of the world that this robot's driver has made or refused; published when they change.
    #[export]
    edits: Export<EditCount>,
    active: Option<ActiveRobot>,
}

/// A robot in a world.
struct ActiveRobot {
    claim: RobotClaim,
    lasers: LaserConfig,
    ring: SonarConfig,
    /// Time at which it entered its world.
    since: Duration,
    /// The count of changes of the world when its static objects were published; `None` before that.
    scenery: Option<u64>,
    /// The edits that were published last.
    edits: Option<EditCount>,
    /// Time at which `movers` is due next; `None` before the first time.
    due: Option<Duration>,
}

impl Schema for Pioneer {
    fn awake(&mut self, cx: &Context) -> Result {
        if self.active.is_none() {
            self.active = Some(self.add_robot(cx)?);
        }
        Ok(())
    }

    fn iterate(&mut self, cx: &Context) -> Result {
        // Taken out during the iteration: after an error the driver drops its robot, which then stops.
        let Some(mut active) = self.active.take() else {
            return Err("it is in no world".into());
        };
        let twist = *self.velocity.get(cx).value();
        let head = *self.head.get(cx).value();
        let mut world = active.claim.world();
        // Up to now the last command applies; the new one applies from now on.
        world.advance_to(cx.now().as_nanos() as u64);
        world.command(active.claim.robot(), Twist2::new(twist.linear.x, twist.angular.z))?;
        let head = HeadCommand {
            pan: head.pan,
            tilt: head.tilt,
            pan_speed: head.pan_velocity,
            tilt_speed: head.tilt_velocity,
        };
        world.command_head(active.claim.robot(), head)?;
        let edits = self.edit(cx, &mut world, &active.claim);
        if active.edits.replace(edits) != Some(edits) {
            self.edits.write(cx, edits);
        }
        self.sense(cx, &world, &active)?;
        if active.scenery.replace(world.changes()) != Some(world.changes()) {
            self.publish_scenery(cx, &world);
        }
        if scenery::is_time(&mut active.due, cx.now()) {
            self.publish_movers(cx, &world, active.claim.robot());
        }
        drop(world);
        self.active = Some(active);
        Ok(())
    }

    fn sleep(&mut self, _: &Context) {
        if let Some(active) = &self.active {
            active.claim.stop();
        }
    }
}

impl Pioneer {
    /// Places the robot at its start.
    fn add_robot(&self, cx: &Context) -> Result<ActiveRobot> {
        let path = self.path(cx)?;
        let (name, config) = (self.robot_name(cx), self.config(cx));
        let lasers = self.lasers(cx);
        let ring = SonarConfig {
            sigma: self.sonar_noise.get(cx),
            ..SonarConfig::default()
        };
        let claim = RobotClaim::acquire((cx.application(), path.as_str(), cx.seed()), |world| {
            find_or_add(world, name.as_str(), self.start(cx), config)
        })?;
        let since = cx.now();
        Ok(ActiveRobot {
            claim,
            lasers,
            ring,
            since,
            scenery: None,
            edits: None,
            due: None,
        })
    }

    fn path(&self, cx: &Context) -> Result<Text<1024>> {
        let path = self.world.get(cx);
        if path.is_empty() {
            return Err(
                "it has no world; give it one in the application: world = \"worlds/office.toml\"".into(),
            );
        }
        Ok(path)
    }

    fn robot_name(&self, cx: &Context) -> String {
        let named = self.robot.get(cx);
        if named.is_empty() {
            cx.name()
        } else {
            named.as_str()
        }
        .to_owned()
    }

    fn start(&self, cx: &Context) -> Option<Pose2> {
        let start = self.start.get(cx);
        let pose = start.pose.first();
        pose.map(|pose| Pose2::new(pose.x, pose.y, pose.theta))
    }

    fn config(&self, cx: &Context) -> RobotConfig {
        let acceleration = self.acceleration.get(cx);
        RobotConfig {
            footprint: Footprint::Circle {
                radius: self.radius.get(cx),
            },
            linear_acceleration: acceleration,
            linear_deceleration: acceleration,
            wheel_scale_sigma: self.wheel_error.get(cx),
            odometry_origin: OdometryOrigin::StartPose,
            ..RobotConfig::default()
        }
    }

    fn lasers(&self, cx: &Context) -> LaserConfig {
        LaserConfig {
            beams: self.laser_beams.get(cx) as usize,
            field_of_view: self.laser_view.get(cx),
            range_max: self.laser_range.get(cx),
            sigma: self.laser_noise.get(cx),
            ..LaserConfig::default()
        }
    }
}

impl Inspect for Pioneer {
    fn inspect(&self, cx: &Context, problems: &mut Problems) {
        problems.expect(&self.laser_range, self.lasers(cx).check());
        let world = self
            .path(cx)
            .and_then(|path| Ok(World::load(path.as_str(), cx.seed())?));
        if let Some(mut world) = problems.expect(&self.world, world) {
            let start = self.start(cx);
            match find_or_add(&mut world, &self.robot_name(cx), start, self.config(cx)) {
                Ok(_) => {}
                Err(error @ (WorldError::PlaceBlocked { .. } | WorldError::BadPlace { .. })) => {
                    problems.wrong(&self.start, error);
                }
                Err(error) => problems.wrong(&self.robot, error),
            }
        }
    }
}

/// Returns the robot of that name. One that is not in the world is added: at `start`, or at that of the file.
fn find_or_add(
    world: &mut World,
    name: &str,
    start: Option<Pose2>,
    config: RobotConfig,
) -> Result<RobotId, WorldError> {
    let present = world.robots().find(|(_, known)| *known == name);
    match (present.map(|(robot, _)| robot), start) {
        (Some(robot), _) => Ok(robot),
        (None, Some(start)) => world.add_robot_at(name, start, config),
        (None, None) => world.add_robot(name, config),
    }
}

jde_schema::export!("sim", "A simulated Pioneer and its cameras.", [Pioneer, Camera]);

#[cfg(test)]
mod tests;
