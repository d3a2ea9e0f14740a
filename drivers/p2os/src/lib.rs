//! Drives Pioneer robots, and simulators that speak their protocol, behind the same ports as the simulated Pioneer. What goes
//! over the wire is the library's; this plugin holds it to a port, a clock and the exports.
//!
//! It has no thread: whatever is said to the robot is said from an iteration. So a schema that hangs or a process that is
//! stopped lets the robot's own watchdog stop it.

mod robot;
mod sense;
mod settings;

use jde_p2os::{HeadWish, Wish};
use jde_schema::prelude::*;

use robot::Robot;
use sense::Senses;

/// A head that stays where it looks.
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

/// A Pioneer robot at a serial line or behind TCP, or a simulator in its place.
///
/// While the robot is not heard its exports are taken back, `connection` says why, and it is looked for again by itself.
#[derive(Describe)]
#[schema(driver, period = "25ms", budget = "25ms")]
pub struct Pioneer {
    /// Where it is: "tcp:HOST:8101", or "serial:/dev/ttyUSB0@9600".
    #[modulation(default = "", fixed)]
    port: Modulation<Text<256>>,
    /// Its model: "p3dx" and the like, or the path of a file that ends in ".toml"; empty for what the robot says it is.
    #[modulation(default = "", fixed)]
    model: Modulation<Text<1024>>,
    /// Where it stands at the beginning, in the frame of the odometry.
    #[modulation(default = Pose2D::ORIGIN, fixed)]
    start: Modulation<Pose2D>,
    /// The laser that simulators send along: "auto" asks simulators for it, "on" whomever, "off" nobody.
    #[modulation(default = "auto", fixed)]
    laser_mode: Modulation<Text<28>>,
    /// Beams of that laser.
    #[modulation(default = 180, min = 1, max = 1088, fixed)]
    laser_beams: Modulation<u32>,
    /// The angle that laser covers, centred ahead; whole degrees, by the protocol.
    #[modulation(default = core::f64::consts::PI, unit = "rad", min = 0.02, max = core::f64::consts::TAU, fixed)]
    laser_view: Modulation<f64>,
    /// The farthest that laser sees.
    #[modulation(default = 8.0, unit = "m", min = 0.1, fixed)]
    laser_range: Modulation<f64>,
    /// The pan-tilt head at its first auxiliary port: "none", "vc-c4", or "vc-c4-one-way" if its answers have no wire.
    #[modulation(default = "none", fixed)]
    head_kind: Modulation<Text<28>>,
    /// Speeds of the base.
    #[command(neutral = Twist::ZERO, validity = "500ms")]
    velocity: Command<Twist>,
    /// Where the head shall look, and how fast it may turn there; an axis without speed stays where it is.
    #[command(neutral = HOLD, validity = "3600s")]
    head: Command<PanTilt>,
    /// The laser that simulators send along.
    #[export]
    laser: Export<LaserScan>,
    /// The sonars, in the robot's own order: from ahead on the left clockwise; NaN until one is heard.
    #[export]
    sonars: Export<RangeRing>,
    /// Pose and velocity as the wheels tell; it goes on where it was after a loss.
    #[export]
    odometry: Export<Odometry>,
    /// The bumpers, and whether the wheels are held.
    #[export]
    bumpers: Export<Bumpers>,
    /// The battery.
    #[export]
    battery: Export<BatteryState>,
    /// What the wheels have counted, if the robot tells.
    #[export]
    encoders: Export<WheelEncoders>,
    /// Where the head looks: by its own word, or reckoned if it cannot answer.
    #[export]
    pan_tilt: Export<PanTilt>,
    /// Whether the robot is heard, what it calls itself, or why it is not heard.
    #[export]
    connection: Export<Connection>,
    robot: Option<Robot>,
    senses: Senses,
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
        let wish = Wish {
            linear: twist.linear.x,
            angular: twist.angular.z,
            head: HeadWish {
                pan: head.pan,
                tilt: head.tilt,
                pan_speed: head.pan_velocity,
                tilt_speed: head.tilt_velocity,
            },
        };
        let stepped = robot.step(&wish);
        let sensed = if robot.is_up() {
            self.sense(cx, &mut robot)
        } else {
            self.take_back(cx);
            Ok(())
        };
        robot.tell(cx, &mut self.connection);
        self.robot = Some(robot);
        stepped.and(sensed)
    }

    fn sleep(&mut self, cx: &Context) {
        if let Some(robot) = &mut self.robot {
            robot.rest();
        }
        self.take_back(cx);
        self.connection.retract(cx);
    }
}

impl Pioneer {
    /// Takes back what no longer tells how things are.
    fn take_back(&mut self, cx: &Context) {
        if !self.senses.forget() {
            return;
        }
        self.laser.retract(cx);
        self.sonars.retract(cx);
        self.odometry.retract(cx);
        self.bumpers.retract(cx);
        self.battery.retract(cx);
        self.encoders.retract(cx);
        self.pan_tilt.retract(cx);
    }
}

jde_schema::export!("p2os", "Drives Pioneer robots.", [Pioneer]);

#[cfg(test)]
mod tests;
