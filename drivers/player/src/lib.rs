//! Drives robots behind Player servers, and the robots of Stage, behind the same ports as the simulated
//! robots. The library `jde-player` implements the protocol; this plugin connects it to a port, a clock and
//! the exports.
//!
//! It has no thread: it sends commands only from iterations. Player has no watchdog: a robot whose client
//! hangs follows its last velocity until the connection ends.

mod convert;
mod link;
mod sense;
mod settings;

use core::time::Duration;

use jde_device::Device;
use jde_player::{HeadSetpoint, Setpoint};
use jde_schema::prelude::*;
use jde_schema::types::Body;

use link::Link;
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

/// Those of most robots for rooms: an application for a faster robot states its own.
const LIMITS: Twist = Twist {
    linear: Vector3 {
        x: 1.0,
        y: 1.0,
        z: 0.0,
    },
    ..Twist::planar(0.0, 2.0)
};

/// A robot behind a Player server of version 3, or one of Stage.
///
/// While the server does not reply, the exports are retracted, `connection` gives the reason, and the driver
/// looks for the robot again by itself.
#[derive(Describe)]
#[schema(driver, period = "25ms", budget = "25ms")]
pub struct Robot {
    /// Address of the server: "tcp:HOST:6665".
    #[modulation(default = "tcp:localhost:6665", fixed)]
    port: Modulation<Text<256>>,
    /// Index of the base, a `position2d`.
    #[modulation(default = 0, max = 65535, fixed)]
    base: Modulation<u32>,
    /// The laser: "ranger:INDEX", "laser:INDEX", "none", or "auto" for the first ranger of one element, or
    /// else the first laser.
    #[modulation(default = "auto", fixed)]
    laser_device: Modulation<Text<28>>,
    /// The sonars: "ranger:INDEX", "sonar:INDEX", "none", or "auto" for the first ranger of several elements,
    /// or else the first sonar.
    #[modulation(default = "auto", fixed)]
    sonar_device: Modulation<Text<28>>,
    /// The bumpers: "bumper:INDEX", "none", or "auto" for the first.
    #[modulation(default = "auto", fixed)]
    bumper_device: Modulation<Text<28>>,
    /// The battery: "power:INDEX", "none", or "auto" for the first.
    #[modulation(default = "auto", fixed)]
    battery_device: Modulation<Text<28>>,
    /// The pan-tilt unit: "ptz:INDEX", "none", or "auto" for the first.
    #[modulation(default = "auto", fixed)]
    head_device: Modulation<Text<28>>,
    /// Greatest range of the laser, if the server does not report it.
    #[modulation(default = 8.0, unit = "m", min = 0.1, fixed)]
    laser_range: Modulation<f64>,
    /// Greatest range of the sonars, if the server does not report it.
    #[modulation(default = 5.0, unit = "m", min = 0.1, fixed)]
    sonar_range: Modulation<f64>,
    /// The angle that a sonar covers, if the server does not report it.
    #[modulation(default = 0.26, unit = "rad", min = 0.0, max = core::f64::consts::TAU, fixed)]
    sonar_view: Modulation<f64>,
    /// The start pose, in the frame of the odometry.
    #[modulation(default = Pose2D::ORIGIN, fixed)]
    start: Modulation<Pose2D>,
    /// Time after which an export without new data is retracted; ten times as long for the battery.
    #[modulation(default = 1.0, unit = "s", min = 0.01, max = 5.0)]
    stale: Modulation<f64>,
    /// Greatest speeds that any command asks of the base, in either direction; 0 limits none.
    #[modulation(default = LIMITS, fixed)]
    #[expect(dead_code, reason = "the host applies them to each command")]
    velocity_limits: Modulation<Twist>,
    /// Speeds of the base. A robot that is not omnidirectional ignores the speed to the side.
    #[command(neutral = Twist::ZERO, validity = "500ms")]
    velocity: Command<Twist>,
    /// Position of the head, and its speeds; an axis with speed 0 stays where it is.
    #[command(neutral = HOLD, validity = "3600s")]
    head: Command<PanTilt>,
    /// The scan of the laser, in the laser's own frame. If it has more beams than fit, groups of adjacent
    /// beams are replaced by their nearest.
    #[export(validity = "5s")]
    laser: Export<LaserScan>,
    /// The sonars, in the robot's own order; the first 32.
    #[export(validity = "5s")]
    sonars: Export<RangeRing>,
    /// Pose and velocity as the server reports them. After a loss it continues with the server's pose.
    #[export(validity = "5s")]
    odometry: Export<Odometry>,
    /// The bumpers, and whether the motors are blocked.
    #[export(validity = "5s")]
    bumpers: Export<Bumpers>,
    /// The battery.
    #[export(lasting)]
    battery: Export<BatteryState>,
    /// Position and speed of the head.
    #[export(validity = "5s")]
    pan_tilt: Export<PanTilt>,
    /// The place of the laser; the server does not report the outline. For windows.
    #[export(lasting)]
    body: Export<Body>,
    /// Whether the robot is connected, its devices, or the reason for the loss.
    #[export(lasting)]
    connection: Export<Connection>,
    device: Option<Device<Link>>,
    senses: SensorState,
}

impl Schema for Robot {
    fn awake(&mut self, cx: &Context) -> Result {
        cx.require_real_time()?;
        if self.device.is_none() {
            self.device = Some(self.settings(cx)?);
        }
        Ok(())
    }

    fn iterate(&mut self, cx: &Context) -> Result {
        let Some(mut device) = self.device.take() else {
            return Err("it is not awake".into());
        };
        let events = device.step(cx);
        self.sense(cx, events);
        let (is_ready, stale) = (device.is_ready(), Duration::from_secs_f64(self.stale.get(cx)));
        self.retract(cx, |age| !is_ready || age > stale);
        if !is_ready {
            self.body.retract(cx);
        }
        let setpoint = self.setpoint(cx);
        let link = device.protocol_mut();
        let bytes = link.map(|link| link.drive(&setpoint, cx.now()));
        device.send(&bytes.unwrap_or_default());
        device.export_connection(cx, &mut self.connection);
        self.device = Some(device);
        Ok(())
    }

    fn sleep(&mut self, cx: &Context) {
        self.stop();
        if let Some(device) = self.device.take() {
            device.close(cx, &mut self.connection);
        }
        self.retract(cx, |_| true);
        self.body.retract(cx);
    }
}

impl Robot {
    fn setpoint(&self, cx: &Context) -> Setpoint {
        let (twist, head) = (self.velocity.get(cx), self.head.get(cx));
        Setpoint {
            velocity: [twist.linear.x, twist.linear.y, twist.angular.z],
            head: HeadSetpoint {
                // Player counts the tilt upwards.
                angles: [head.pan as f32, -head.tilt as f32],
                speeds: [head.pan_velocity as f32, head.tilt_velocity as f32],
            },
        }
    }

    /// Sends the bytes that stop the robot.
    fn stop(&mut self) {
        if let Some(device) = &mut self.device {
            let bytes = device.protocol_mut().map(|link| link.stop());
            device.send(&bytes.unwrap_or_default());
        }
    }
}

/// Dropping the driver stops its robot.
impl Drop for Robot {
    fn drop(&mut self) {
        self.stop();
    }
}

jde_schema::export!(
    "player",
    "Drives robots behind Player servers, and those of Stage.",
    [Robot]
);

#[cfg(test)]
mod tests;
