//! Simulated robots with their cameras and lasers as drivers: the library `jde-sim` behind the ports of a
//! robot. A robot steps the world to the application's time. The drivers depend on no schedule and on no
//! other schema.

mod camera;
mod dynamics;
mod edits;
mod entry;
mod laser;
mod models;
mod output;
mod scenery;
mod sense;
mod worlds;

use jde_motion::BaseDynamics;
use jde_schema::prelude::*;
use jde_schema::types::{Body, Movers, Scenery, Start};
use jde_sim::{HeadCommand, RobotModel, Twist2, WorldError};

pub use camera::Camera;
pub use edits::EditCount;
use entry::{ActiveRobot, Entry};
pub use laser::Laser;
use models::Overrides;
use scenery::PUBLISH_PERIOD;

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

/// A robot of a robot file in a simulated world. Several in one application share the world.
///
/// It publishes the sensors that the robot has, each at its own rate where that is lower than that of the
/// driver. A `sim/laser` publishes a further laser.
///
/// Frames by REP-105: the odometry starts at the robot's start pose in the world, so that `odom`
/// equals the world's frame except for the drift of the wheels.
#[derive(Describe)]
#[schema(driver, period = "50ms", budget = "50ms")]
pub struct Robot {
    /// The world file.
    #[modulation(default = "", unit = "file", fixed)]
    world: Modulation<Text<1024>>,
    /// The robot's name in the world file; empty for the name of this schema.
    #[modulation(default = "", fixed)]
    robot: Modulation<Text<60>>,
    /// Where it starts instead of at its start in the world file:
    /// `[{ x = 1.0, y = 2.0, theta = "90 deg" }]`.
    #[modulation(default = Start::NONE, fixed)]
    start: Modulation<Start>,
    /// Changes of the world while it runs. Each write takes effect once, at the next iteration.
    #[modulation(default = "")]
    edit: Modulation<Text<4096>>,
    /// The robot: a shipped one, such as `turtlebot4`, or a robot file, `my-robot.toml`.
    #[modulation(default = "pioneer-3dx", unit = "model", fixed)]
    model: Modulation<Text<1024>>,
    /// Greatest range of the first laser; negative for that of the file.
    #[modulation(default = -1.0, unit = "m", fixed)]
    laser_range: Modulation<f64>,
    /// How high the lasers are: they see no fixed or movable thing that is lower; negative for that of the file.
    #[modulation(default = -1.0, unit = "m", max = 10.0, fixed)]
    laser_height: Modulation<f64>,
    /// Standard deviation of the lasers' ranges; negative for that of the file.
    #[modulation(default = -1.0, unit = "m", fixed)]
    laser_noise: Modulation<f64>,
    /// Intensity that the lasers measure of a white surface; negative for that of the file, 0 for no intensities.
    #[modulation(default = -1.0, fixed)]
    laser_intensity: Modulation<f64>,
    /// Standard deviation of the sonars' ranges; negative for that of the file.
    #[modulation(default = -1.0, unit = "m", fixed)]
    sonar_noise: Modulation<f64>,
    /// Standard deviation of each wheel's scale error, as a fraction; negative for that of the file. It
    /// determines the drift of the odometry.
    #[modulation(default = -1.0, max = 0.5, fixed)]
    wheel_error: Modulation<f64>,
    /// Greatest change of speed per second, ahead and to the side; negative for that of the file.
    #[modulation(default = -1.0, unit = "m/s2", fixed)]
    acceleration: Modulation<f64>,
    /// Time constant of the motors; negative for that of the file.
    #[modulation(default = -1.0, unit = "s", max = 2.0, fixed)]
    lag: Modulation<f64>,
    /// Charge of a full battery; negative for the 21.6 Ah of a Pioneer. A robot without a battery gets one.
    #[modulation(default = -1.0, unit = "Ah", fixed)]
    battery_capacity: Modulation<f64>,
    /// Greatest speeds that any command asks of the base, in either direction; 0 limits none. The robot follows a command
    /// at most with the speeds of its file.
    #[modulation(default = Twist::ZERO, fixed)]
    #[expect(dead_code, reason = "the host applies them to each command")]
    velocity_limits: Modulation<Twist>,
    /// Speeds of the base. A robot that is not omnidirectional ignores the speed to the side; a car
    /// drives the curvature of the command.
    #[command(neutral = Twist::ZERO, validity = "500ms")]
    velocity: Command<Twist>,
    /// Position of the pan-tilt head, and its speeds, whose signs are ignored; a speed of 0 holds its
    /// axis. Without a new command the head continues to the last position and stays there, so a
    /// command is valid for an hour.
    #[command(neutral = HOLD, validity = "3600s")]
    head: Command<PanTilt>,
    /// The scan of the first laser, in the laser's own frame. Its time is that of its first beam.
    #[export(validity = "1s")]
    laser: Export<LaserScan>,
    /// The sonars, in the order of the robot's file. A Pioneer has eight ahead from left to right,
    /// then eight behind from right to left.
    #[export(validity = "1s")]
    sonars: Export<RangeRing>,
    /// The brightness of the floor below each cell of the line sensor, in the order of the robot's file.
    #[export(validity = "1s")]
    line_sensor: Export<LineSensor>,
    /// The measurements of the inertial unit, in its own frame. It estimates no orientation.
    #[export(validity = "1s")]
    imu: Export<Imu>,
    /// The position in the frame of the world; none in an outage.
    #[export(validity = "2s")]
    position: Export<PositionFix>,
    /// Pose and velocity from the wheels.
    #[export]
    odometry: Export<Odometry>,
    /// Five bumpers ahead, five behind, and whether the wheels are blocked.
    #[export]
    bumpers: Export<Bumpers>,
    /// Position and speed of the head.
    #[export]
    pan_tilt: Export<PanTilt>,
    /// Voltage, current and charge of lead-acid blocks.
    #[export(lasting)]
    battery: Export<BatteryState>,
    /// The counts of the wheels.
    #[export]
    encoders: Export<WheelEncoders>,
    /// Always connected. Its stamp is the time at which the robot entered its world, and its note
    /// names the world.
    #[export(lasting)]
    connection: Export<Connection>,
    /// The true state of the robot, for measurements. A schema that steers by it would work only in
    /// the simulator.
    #[export(lasting)]
    truth: Export<Truth>,
    /// The outline of the robot's file and the places of its lasers; for windows and pictures.
    #[export(lasting)]
    body: Export<Body>,
    /// How the robot follows its commands, by its file and `acceleration` and `lag` here.
    #[export(lasting)]
    dynamics: Export<BaseDynamics>,
    /// What the motors are led to at present: the commands so far, within the limits of the robot's file. A car has none,
    /// nor has a robot that accelerates otherwise to the side than ahead.
    #[export]
    setpoint: Export<Twist>,
    /// The static objects of the world, published when the robot enters it and when they change; for
    /// windows. No robot has such a sensor.
    #[export(lasting)]
    scenery: Export<Scenery>,
    /// The objects that move or can be moved, ten times per second; for windows. No robot has such a
    /// sensor.
    #[export(lasting)]
    movers: Export<Movers>,
    /// The changes of the world that this robot's driver has made or refused; published when they
    /// change.
    #[export(lasting)]
    edits: Export<EditCount>,
    active: Option<ActiveRobot>,
}

impl Robot {
    /// Returns the robot of its file with the numbers of the application.
    fn model(&self, cx: &Context) -> Result<RobotModel> {
        let overrides = Overrides {
            laser_range: self.laser_range.get(cx),
            laser_height: self.laser_height.get(cx),
            laser_noise: self.laser_noise.get(cx),
            laser_intensity: self.laser_intensity.get(cx),
            sonar_noise: self.sonar_noise.get(cx),
            wheel_error: self.wheel_error.get(cx),
            acceleration: self.acceleration.get(cx),
            lag: self.lag.get(cx),
            battery_capacity: self.battery_capacity.get(cx),
        };
        let model = RobotModel::find(self.model.get(cx).as_str());
        overrides.over(model.map_err(|error| format!("{error:#}"))?)
    }

    /// Steps the world to the present time, commands the robot and publishes what it senses.
    fn step(&mut self, cx: &Context, active: &mut ActiveRobot) -> Result {
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
        self.publish_setpoint(cx, &active.model.config, &mut active.setpoint, twist);
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
        let truth = world.truth(robot);
        if truth.collisions > active.contacts {
            let (nearest, pose) = (world.nearest_name(robot), truth.pose);
            warn!(cx, "it touches {nearest} at {:.2}, {:.2} m", pose.x, pose.y);
        }
        active.contacts = truth.collisions;
        self.publish_connection(cx, &world, active.since);
        if active.scenery.is_none() {
            self.publish_body(cx, &active.model);
            self.publish_dynamics(cx, &active.model.config);
        }
        if active.scenery.replace(world.changes()) != Some(world.changes()) {
            self.publish_scenery(cx, &world);
        }
        if scenery::is_time(&mut active.due.movers, cx.now(), PUBLISH_PERIOD) {
            self.publish_movers(cx, &world, robot);
        }
        Ok(())
    }
}

impl Schema for Robot {
    fn awake(&mut self, cx: &Context) -> Result {
        if self.active.is_none() {
            self.active = Some(ActiveRobot::enter(cx, Entry::new(cx, self), self.model(cx)?)?);
        }
        Ok(())
    }

    fn iterate(&mut self, cx: &Context) -> Result {
        // Taken out during the iteration: after an error the driver drops its robot, which then stops.
        let Some(mut active) = self.active.take() else {
            return Err("it is in no world".into());
        };
        self.step(cx, &mut active)?;
        self.active = Some(active);
        Ok(())
    }

    fn sleep(&mut self, _: &Context) {
        if let Some(active) = &mut self.active {
            active.stop();
        }
    }
}

impl Inspect for Robot {
    fn inspect(&self, cx: &Context, problems: &mut Problems) {
        let model = problems.expect(&self.model, self.model(cx));
        if let Some(model) = &model {
            self.name_absent(model, problems);
        }
        let entry = Entry::new(cx, self);
        let world = entry.path().and_then(|path| Ok(worlds::load(path, cx.seed())?));
        let (Some(mut world), Some(model)) = (problems.expect(&self.world, world), model) else {
            return;
        };
        match entry.find_or_add(&mut world, model.config) {
            Ok(_) => {}
            Err(error @ (WorldError::PlaceBlocked { .. } | WorldError::BadPlace { .. })) => {
                problems.wrong(&self.start, error);
            }
            Err(error) => problems.wrong(&self.robot, error),
        }
    }
}

impl Robot {
    /// Names the sensors that the robot does not have.
    fn name_absent(&self, model: &RobotModel, problems: &mut Problems) {
        let name = &model.name;
        let words = |sensor: &str, table: &str| {
            format!("the robot `{name}` has no {sensor}: its file has no {table}")
        };
        if model.lasers.is_empty() {
            problems.absent(&self.laser, words("laser", "[[lasers]]"));
        }
        if model.sonars.is_none() {
            problems.absent(&self.sonars, words("sonars", "[sonars]"));
        }
        if model.line_sensor.is_none() {
            problems.absent(&self.line_sensor, words("line sensor", "[line_sensor]"));
        }
        if model.imu.is_none() {
            problems.absent(&self.imu, words("inertial unit", "[imu]"));
        }
        if model.position.is_none() {
            problems.absent(&self.position, words("position sensor", "[position]"));
        }
    }
}

jde_schema::export!(
    "sim",
    "Simulated robots, their cameras and lasers.",
    [Robot, Camera, Laser]
);

#[cfg(test)]
mod tests;
