//! Drives Pioneer robots, and simulators with the same protocol, behind the same ports as the simulated
//! Pioneer. The library `jde-p2os` implements the protocol; this plugin connects it to a port, a clock and
//! the exports.
//!
//! It has no thread: it sends commands only from iterations. If a schema hangs or the process is stopped, the
//! robot's own watchdog stops the robot.

mod robot;
mod sense;
mod settings;

use jde_motion::BaseDynamics;
use jde_p2os::{HeadSetpoint, Setpoint};
use jde_schema::prelude::*;
use jde_schema::types::Body;

use robot::RobotConnection;
use sense::SensorState;

/// A head command that holds both axes.
const HOLD: PanTilt = PanTilt {
    header: Header {
        stamp: Time { sec: 0, nanosec: 0 },
        frame_id: Frame::new(""),
    },
    pan: 0.0,
    tilt: 0.0,
    pan_velocity: 0.0,
    tilt_velocity: 0.0,
};

/// Those of the data sheet of the P3-DX; the firmware of a slower robot has lower ones of its own.
const LIMITS: Twist = Twist {
    linear: Vector3 {
        x: 1.2,
        y: 0.0,
        z: 0.0,
    },
    ..Twist::planar(0.0, 5.24)
};

/// A Pioneer robot at a serial line or behind TCP, or a simulator in its place.
///
/// While the robot does not reply, its exports are retracted, `connection` gives the reason, and the driver
/// looks for it again by itself.
#[derive(Describe)]
#[schema(driver, period = "25ms", budget = "25ms")]
pub struct Pioneer {
    /// Its address: "tcp:HOST:8101", or "serial:/dev/ttyUSB0@9600".
    #[modulation(default = "", fixed)]
    port: Modulation<Text<256>>,
    /// Its model: "p3dx" and the like, or the path of a file that ends in ".toml"; empty for the model that
    /// the robot reports.
    #[modulation(default = "", unit = "model", fixed)]
    model: Modulation<Text<1024>>,
    /// The start pose, in the frame of the odometry.
    #[modulation(default = Pose2D::ORIGIN, fixed)]
    start: Modulation<Pose2D>,
    /// The laser of simulators: "auto" requests it from simulators, "on" from every robot, "off" from none.
    #[modulation(default = "auto", fixed)]
    laser_mode: Modulation<Text<28>>,
    /// Beams of that laser.
    #[modulation(default = 180, min = 1, max = 1088, fixed)]
    laser_beams: Modulation<u32>,
    /// The angle that the laser covers, centred ahead; whole degrees, by the protocol.
    #[modulation(default = core::f64::consts::PI, unit = "rad", min = 0.02, max = core::f64::consts::TAU, fixed)]
    laser_view: Modulation<f64>,
    /// Greatest range of that laser.
    #[modulation(default = 8.0, unit = "m", min = 0.1, fixed)]
    laser_range: Modulation<f64>,
    /// The pan-tilt head at the first auxiliary port: "none", "vc-c4", or "vc-c4-one-way" if its replies are
    /// not wired.
    #[modulation(default = "none", fixed)]
    head_kind: Modulation<Text<28>>,
    /// Greatest speeds that any command asks of the base, in either direction; 0 limits none.
    #[modulation(default = LIMITS, fixed)]
    #[expect(dead_code, reason = "the host applies them to each command")]
    velocity_limits: Modulation<Twist>,
    /// Speeds of the base.
    #[command(neutral = Twist::ZERO, validity = "500ms")]
    velocity: Command<Twist>,
    /// Position of the head, and its speeds; an axis with speed 0 stays where it is.
    #[command(neutral = HOLD, validity = "3600s")]
    head: Command<PanTilt>,
    /// The scan of the laser of simulators.
    #[export(validity = "1s")]
    laser: Export<LaserScan>,
    /// The sonars, in the robot's own order: from ahead on the left clockwise. NaN until the first reading of
    /// a sonar.
    #[export(validity = "1s")]
    sonars: Export<RangeRing>,
    /// Pose and velocity from the wheels. After a loss it continues from the last pose.
    #[export(validity = "1s")]
    odometry: Export<Odometry>,
    /// The bumpers, and whether the wheels are blocked.
    #[export(validity = "1s")]
    bumpers: Export<Bumpers>,
    /// The battery.
    #[export(lasting)]
    battery: Export<BatteryState>,
    /// The counts of the wheels, if the robot reports them.
    #[export(validity = "1s")]
    encoders: Export<WheelEncoders>,
    /// Position of the head: measured, or estimated if the head cannot reply.
    #[export(validity = "1s")]
    pan_tilt: Export<PanTilt>,
    /// The radius in which the robot turns, and the usual place of its laser; for windows and pictures.
    #[export(lasting)]
    body: Export<Body>,
    /// How the robot follows its commands: the accelerations of its settings, 0 until it has stated them. Its lag is unknown.
    #[export(lasting)]
    dynamics: Export<BaseDynamics>,
    /// Whether the robot is connected, its name, or the reason for the loss.
    #[export(lasting)]
    connection: Export<Connection>,
    robot: Option<RobotConnection>,
    senses: SensorState,
}

impl Schema for Pioneer {
    fn awake(&mut self, cx: &Context) -> Result {
        cx.require_real_time()?;
        if self.robot.is_none() {
            self.robot = Some(self.settings(cx)?);
        }
        Ok(())
    }

    fn iterate(&mut self, cx: &Context) -> Result {
        let Some(mut robot) = self.robot.take() else {
            return Err("it is not awake".into());
        };
        let (twist, head) = (self.velocity.get(cx), self.head.get(cx));
        let setpoint = Setpoint {
            linear: twist.linear.x,
            angular: twist.angular.z,
            head: HeadSetpoint {
                pan: head.pan,
                tilt: head.tilt,
                pan_speed: head.pan_velocity,
                tilt_speed: head.tilt_velocity,
            },
        };
        let step_result = robot.step(&setpoint);
        let sense_result = if robot.is_up() {
            self.sense(cx, &mut robot)
        } else {
            self.retract_exports(cx);
            Ok(())
        };
        robot.export_connection(cx, &mut self.connection);
        self.robot = Some(robot);
        step_result.and(sense_result)
    }

    fn sleep(&mut self, cx: &Context) {
        if let Some(robot) = &mut self.robot {
            robot.close();
        }
        self.retract_exports(cx);
        self.connection.retract(cx);
    }
}

impl Pioneer {
    /// Retracts the exports, because they no longer describe the robot.
    fn retract_exports(&mut self, cx: &Context) {
        if !self.senses.reset() {
            return;
        }
        self.laser.retract(cx);
        self.sonars.retract(cx);
        self.odometry.retract(cx);
        self.bumpers.retract(cx);
        self.battery.retract(cx);
        self.encoders.retract(cx);
        self.pan_tilt.retract(cx);
        self.body.retract(cx);
        self.dynamics.retract(cx);
    }
}

jde_schema::export!("p2os", "Drives Pioneer robots.", [Pioneer]);

#[cfg(test)]
mod tests;
