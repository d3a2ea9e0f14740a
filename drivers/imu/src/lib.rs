//! Drives inertial measurement units at serial lines. The modules of the protocol do no I/O; this file connects them to a
//! port, a clock and the exports.

#[cfg(test)]
mod checks;
#[cfg(test)]
mod emulator;
mod frame;
mod session;
mod set;

use jde_device::port::{Address, Backoff, Port};
use jde_device::{Device, inspect_port};
use jde_schema::prelude::*;

use session::{Reading, WitConfig, WitSession};

/// Standard deviations by the data sheet of the WT901: noise of a turn rate, rad/s.
const RATE_DEVIATION: f64 = 0.002;
/// Of an acceleration, m/s².
const ACCELERATION_DEVIATION: f64 = 0.02;
/// Of roll and pitch while it moves, rad.
const TILT_DEVIATION: f64 = 0.01;
/// Of a heading by the compass, rad: iron nearby turns it more.
const COMPASS_DEVIATION: f64 = 0.05;
/// Of a heading without a compass, rad: it may be any.
const ANY_HEADING: f64 = core::f64::consts::PI;

/// An inertial unit of WIT-Motion (WT901, JY901, WT61 and the like) at a serial line.
///
/// The unit sends without being asked, and the driver changes nothing in it. It checks what comes, and reconnects by itself
/// after every loss.
#[derive(Describe)]
#[schema(driver, period = "5ms", budget = "20ms")]
pub(crate) struct Wit {
    /// Its address: "serial:/dev/ttyUSB0@115200", or "tcp:HOST:PORT" of a serial server.
    #[modulation(default = "", fixed)]
    port: Modulation<Text<256>>,
    /// How often it should send in a second, as it is set; a warning says if it sends less. With 0, any rate is right.
    #[modulation(default = 0.0, unit = "Hz", min = 0.0, max = 1000.0, fixed)]
    rate: Modulation<f64>,
    /// Whether its heading is that of its compass: its algorithm of 9 axes. That of 6 axes drifts, and is stated as unknown.
    #[modulation(default = false, fixed)]
    compass: Modulation<bool>,
    /// Turn rates, accelerations and the orientation, about the axes of the unit.
    #[export(validity = "500ms")]
    imu: Export<Imu>,
    /// Whether the unit is connected.
    #[export(lasting)]
    connection: Export<Connection>,
    device: Option<Device<WitSession>>,
    is_exported: bool,
}

impl Schema for Wit {
    fn awake(&mut self, cx: &Context) -> Result {
        cx.require_real_time()?;
        if self.device.is_none() {
            let config = WitConfig {
                rate: self.rate.get(cx),
            };
            let port = Port::new(self.address(cx)?, Backoff::default());
            self.device = Some(Device::new(port, config));
        }
        Ok(())
    }

    fn iterate(&mut self, cx: &Context) -> Result {
        let Some(device) = &mut self.device else {
            return Err("it is not awake".into());
        };
        // Of several, the last one counts: a variable has its newest value.
        let newest = device.step(cx).pop();
        let is_ready = device.is_ready();
        device.export_connection(cx, &mut self.connection);
        if let Some(reading) = newest {
            let imu = message(&reading, cx.now(), self.compass.get(cx));
            self.imu.write(cx, imu);
            self.is_exported = true;
        }
        if !is_ready && core::mem::take(&mut self.is_exported) {
            self.imu.retract(cx);
        }
        Ok(())
    }

    fn sleep(&mut self, cx: &Context) {
        if let Some(device) = self.device.take() {
            device.close(cx, &mut self.connection);
        }
        self.imu.retract(cx);
        self.is_exported = false;
    }
}

impl Wit {
    fn address(&self, cx: &Context) -> Result<Address> {
        let port = self.port.get(cx);
        if port.is_empty() {
            let example = "serial:/dev/ttyUSB0@115200";
            return Err(
                format!("it has no port; give it one in the application: port = \"{example}\"").into(),
            );
        }
        Ok(Address::parse(port.as_str())?)
    }
}

impl Inspect for Wit {
    fn inspect(&self, cx: &Context, problems: &mut Problems) {
        inspect_port(&self.port, self.address(cx), problems);
    }
}

/// The message of ROS (REP-145).
fn message(reading: &Reading, now: Duration, compass: bool) -> Imu {
    let vector = |[x, y, z]: [f64; 3]| Vector3 { x, y, z };
    let diagonal = |deviations: [f64; 3]| {
        let mut covariance = [0.0; 9];
        for (at, deviation) in [0, 4, 8].into_iter().zip(deviations) {
            covariance[at] = deviation * deviation;
        }
        covariance
    };
    let mut none = [0.0; 9];
    none[0] = -1.0;
    let heading = if compass { COMPASS_DEVIATION } else { ANY_HEADING };
    let [x, y, z, w] = reading.orientation.unwrap_or([0.0, 0.0, 0.0, 1.0]);
    let tilt = TILT_DEVIATION;
    Imu {
        header: Header::new(now, "imu"),
        orientation: Quaternion { x, y, z, w },
        orientation_covariance: reading
            .orientation
            .map_or(none, |_| diagonal([tilt, tilt, heading])),
        angular_velocity: vector(reading.rates),
        angular_velocity_covariance: diagonal([RATE_DEVIATION; 3]),
        linear_acceleration: vector(reading.acceleration.unwrap_or_default()),
        linear_acceleration_covariance: reading
            .acceleration
            .map_or(none, |_| diagonal([ACCELERATION_DEVIATION; 3])),
    }
}

jde_schema::export!("imu", "Drives inertial units at serial lines.", [Wit]);

#[cfg(test)]
mod tests;
