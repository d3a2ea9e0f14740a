//! `lidar/rplidar`: SLAMTEC's lidars. This file connects the session to the exports.

#[cfg(test)]
pub(crate) mod emulator;
pub(crate) mod message;
pub(crate) mod samples;
pub(crate) mod session;

use jde_device::inspect_port;
use jde_device::port::Address;
use jde_schema::prelude::*;

use crate::scanner::{self, Scanner};
use session::{RplidarConfig, RplidarSession};

/// A lidar of SLAMTEC (RPLIDAR A1, A2, A3, C1, S1, S2) at a serial line.
///
/// The driver finds the lidar at any of its speeds, starts it, and reconnects by itself after every loss.
#[derive(Describe)]
#[schema(driver, period = "5ms", budget = "20ms")]
pub(crate) struct Rplidar {
    /// Its address: "serial:/dev/ttyUSB0@115200", or "tcp:HOST:PORT" of a serial server, which must have the lidar's speed.
    #[modulation(default = "", fixed)]
    port: Modulation<Text<256>>,
    /// The serial number that it must have, 32 hexadecimal digits; empty for any.
    #[modulation(default = "", fixed)]
    serial_number: Modulation<Text<64>>,
    /// How it scans: "Standard", which every model has, or empty for the mode that it recommends, if this driver reads it.
    #[modulation(default = "", fixed)]
    scan_mode: Modulation<Text<16>>,
    /// Beams of a scan, over the whole turn. Of several points at a beam, the nearest counts.
    #[modulation(default = 360, min = 90, max = 1088, fixed)]
    beams: Modulation<u32>,
    /// Whether it hangs upside down.
    #[modulation(default = false, fixed)]
    inverted: Modulation<bool>,
    /// The scan, counter-clockwise from behind. The lidar rotates clockwise: `time_increment` is negative unless it is
    /// `inverted`.
    #[export(validity = "1s")]
    laser: Export<LaserScan>,
    /// Whether the lidar is connected.
    #[export(lasting)]
    connection: Export<Connection>,
    scanner: Option<Scanner<RplidarSession>>,
}

impl Schema for Rplidar {
    fn awake(&mut self, cx: &Context) -> Result {
        cx.require_real_time()?;
        if self.scanner.is_none() {
            let (address, inverted) = (self.address(cx)?, self.inverted.get(cx));
            let config = RplidarConfig {
                beams: self.beams.get(cx) as usize,
                inverted,
                baud: match address {
                    Address::Serial { baud, .. } => Some(baud),
                    Address::Tcp { .. } => None,
                },
                serial_number: self.serial_number(cx)?,
                standard: self.is_standard(cx)?,
            };
            self.scanner = Some(Scanner::new(address, config, inverted));
        }
        Ok(())
    }

    fn iterate(&mut self, cx: &Context) -> Result {
        let Some(scanner) = &mut self.scanner else {
            return Err("it is not awake".into());
        };
        scanner.step(cx, &mut self.laser, &mut self.connection)
    }

    fn sleep(&mut self, cx: &Context) {
        if let Some(scanner) = self.scanner.take() {
            scanner.close(cx, &mut self.laser, &mut self.connection);
        }
    }
}

impl Rplidar {
    fn address(&self, cx: &Context) -> Result<Address> {
        scanner::address(&self.port.get(cx), "serial:/dev/ttyUSB0@115200")
    }

    fn serial_number(&self, cx: &Context) -> Result<String> {
        let number = self.serial_number.get(cx);
        let is_digits = number.as_str().chars().all(|digit| digit.is_ascii_hexdigit());
        if is_digits && [0, 32].contains(&number.as_str().len()) {
            Ok(number.as_str().to_owned())
        } else {
            Err(format!(
                "serial_number = `{number}`: it has 32 hexadecimal digits; the note of `connection` shows that of a lidar"
            )
            .into())
        }
    }

    fn is_standard(&self, cx: &Context) -> Result<bool> {
        match self.scan_mode.get(cx).as_str() {
            "" => Ok(false),
            "Standard" => Ok(true),
            other => Err(format!("scan_mode = `{other}`: it can be `Standard` or empty").into()),
        }
    }
}

impl Inspect for Rplidar {
    fn inspect(&self, cx: &Context, problems: &mut Problems) {
        inspect_port(&self.port, self.address(cx), problems);
        problems.expect(&self.serial_number, self.serial_number(cx));
        problems.expect(&self.scan_mode, self.is_standard(cx));
    }
}

#[cfg(test)]
mod tests;
