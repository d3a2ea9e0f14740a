//! Drives home-made bases at a serial line: `base/serial`. The modules of the protocol do no I/O; this file connects them
//! to a port, a clock and the exports. The sketch for the board is in the folder `sketch`.
//!
//! It has no thread: it sends commands only from iterations. If the process is stopped or killed, the board's own watchdog
//! stops the base.

mod hello;
mod line;
mod odometer;
mod publish;
mod report;
mod session;

use jde_device::port::{Address, Backoff, Port};
use jde_device::{Device, inspect_port};
use jde_motion::{BaseDynamics, Setpoint};
use jde_schema::prelude::*;

use hello::Hello;
use session::{BaseConfig, BaseSession, Data};

/// Slow ones, for the first drive of a robot.
const LIMITS: Twist = Twist {
    linear: Vector3 {
        x: 0.5,
        y: 0.5,
        z: 0.0,
    },
    ..Twist::planar(0.0, 2.0)
};

/// A base of your own at a serial line, differential or omnidirectional, whose board has the sketch or speaks its protocol.
///
/// What the board has is exported, and nothing else. While it does not reply, the exports are retracted, `connection` gives
/// the reason, and the driver looks for it again by itself.
#[derive(Describe)]
#[schema(driver, period = "10ms", budget = "20ms")]
pub(crate) struct Serial {
    /// Its address: "serial:/dev/ttyUSB0@115200", or "tcp:HOST:PORT" of a serial server.
    #[modulation(default = "", fixed)]
    port: Modulation<Text<256>>,
    /// The serial number that its board must state; empty for any.
    #[modulation(default = "", fixed)]
    serial_number: Modulation<Text<64>>,
    /// The start pose, in the frame of the odometry.
    #[modulation(default = Pose2D::ORIGIN, fixed)]
    start: Modulation<Pose2D>,
    /// Greatest speeds that any command asks of the base, in either direction; 0 limits none. Those of the board count, too.
    #[modulation(default = LIMITS, fixed)]
    velocity_limits: Modulation<Twist>,
    /// Speeds of the base. A differential one ignores the speed to the side.
    #[command(neutral = Twist::ZERO, validity = "500ms")]
    velocity: Command<Twist>,
    /// Pose and velocity from the wheels. After a loss, and when the board starts anew, it goes on from the last pose. None
    /// while the board has stopped its motors because a wheel is blocked, or its encoder fails.
    #[export(validity = "500ms")]
    odometry: Export<Odometry>,
    /// The counts of the wheels of a differential base.
    #[export(validity = "500ms")]
    encoders: Export<WheelEncoders>,
    /// The bumpers, and whether the wheels are blocked.
    #[export(validity = "500ms")]
    bumpers: Export<Bumpers>,
    /// The battery, if the board measures it.
    #[export(validity = "2s")]
    battery: Export<BatteryState>,
    /// Turn rates and accelerations, if the board has an inertial unit. It estimates no orientation.
    #[export(validity = "500ms")]
    imu: Export<Imu>,
    /// How the base follows its commands, as the board states it; 0 is unknown.
    #[export(lasting)]
    dynamics: Export<BaseDynamics>,
    /// What the motors are led to, if the board states its accelerations, while it follows commands.
    #[export]
    setpoint: Export<Twist>,
    /// Whether the board is connected and what it is, or why not.
    #[export(lasting)]
    connection: Export<Connection>,
    device: Option<Device<BaseSession>>,
    state: BaseState,
}

/// What is kept while the driver lives.
#[derive(Default)]
struct BaseState {
    pose: Option<Pose2D>,
    /// Ticks of the wheels since the first line.
    ticks: [i64; 2],
    hello: Option<Box<Hello>>,
    setpoint: Setpoint,
    /// Whether the board follows commands: it acknowledges one, and has not stopped its motors.
    is_following: bool,
    /// Whether the board has stopped its motors.
    is_stalled: bool,
    /// Whether there are exports to retract.
    has_exports: bool,
}

impl Schema for Serial {
    fn awake(&mut self, cx: &Context) -> Result {
        cx.require_real_time()?;
        if self.device.is_none() {
            let config = BaseConfig {
                serial_number: self.serial_number.get(cx).to_string(),
            };
            let port = Port::new(self.address(cx)?, Backoff::default());
            self.device = Some(Device::new(port, config));
            self.state.pose.get_or_insert(self.start.get(cx));
        }
        Ok(())
    }

    fn iterate(&mut self, cx: &Context) -> Result {
        let Some(mut device) = self.device.take() else {
            return Err("it is not awake".into());
        };
        let twist = *self.velocity.get(cx);
        let data = device.step(cx);
        let result = self.take(cx, data, device.is_ready());
        let wanted = self.within_limits(&twist);
        let bytes = device
            .protocol_mut()
            .map(|session| session.drive(&wanted, cx.now()));
        device.send(&bytes.unwrap_or_default());
        if device.is_ready() {
            self.publish_setpoint(cx, wanted);
        } else {
            self.retract_exports(cx);
        }
        device.export_connection(cx, &mut self.connection);
        self.device = Some(device);
        result
    }

    fn sleep(&mut self, cx: &Context) {
        if let Some(device) = self.device.take() {
            device.close(cx, &mut self.connection);
        }
        self.retract_exports(cx);
    }
}

impl Serial {
    /// Takes what the board has sent: its motion always, and of the rest what is new.
    fn take(&mut self, cx: &Context, data: Vec<Data>, is_ready: bool) -> Result {
        let mut newest = None;
        for datum in data {
            match datum {
                Data::Hello(hello) => {
                    if hello.is_slower_than(&self.velocity_limits.get(cx)) {
                        let Twist { linear, angular } = hello.limits;
                        warn!(
                            cx,
                            "the board's limits, {} m/s, {} m/s to the side and {} rad/s, are below `velocity_limits`: faster \
                             commands are lessened after guards have judged them",
                            linear.x,
                            linear.y,
                            angular.z
                        );
                    }
                    self.state.hello = Some(hello);
                }
                Data::State { report, step, age } => {
                    let pose = self.state.pose.unwrap_or(Pose2D::ORIGIN);
                    self.state.pose = Some(pose.transform(&step.motion));
                    for (sum, ticks) in self.state.ticks.iter_mut().zip(step.ticks) {
                        *sum += ticks;
                    }
                    newest = Some((report, step, age));
                }
            }
        }
        match newest {
            Some((report, step, age)) if is_ready && age < session::SILENCE => {
                self.publish(cx, &report, &step, cx.now().saturating_sub(age))
            }
            Some(_) | None => Ok(()),
        }
    }

    /// Returns the speeds of a command that the board can have.
    fn within_limits(&self, twist: &Twist) -> Twist {
        let hello = self.state.hello.as_ref();
        hello.map_or(Twist::ZERO, |hello| hello.within_limits(twist))
    }

    fn address(&self, cx: &Context) -> Result<Address> {
        let port = self.port.get(cx);
        if port.is_empty() {
            return Err(
                "it has no port; give it one in the application: port = \"serial:/dev/ttyUSB0@115200\""
                    .into(),
            );
        }
        Ok(Address::parse(port.as_str())?)
    }
}

impl Inspect for Serial {
    fn inspect(&self, cx: &Context, problems: &mut Problems) {
        inspect_port(&self.port, self.address(cx), problems);
    }
}

jde_schema::export!("base", "Drives home-made bases at a serial line.", [Serial]);

#[cfg(test)]
mod tests;
