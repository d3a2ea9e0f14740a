//! `lidar/ld`: LDRobot's lidars LD06, LD19 and STL-19P. This file connects the session to the exports.

#[cfg(test)]
pub(crate) mod emulator;
pub(crate) mod frame;
#[cfg(test)]
mod frame_tests;
pub(crate) mod session;

use jde_device::inspect_port;
use jde_device::port::Address;
use jde_schema::prelude::*;

use crate::scanner::{self, Scanner};
use session::{LdConfig, LdSession};

/// A lidar of LDRobot (LD06, LD19, STL-19P) at a serial line.
///
/// The lidar sends without being asked. The driver checks what it sends, and reconnects by itself after every loss.
#[derive(Describe)]
#[schema(driver, period = "10ms", budget = "20ms")]
pub(crate) struct Ld {
    /// Its address: "serial:/dev/ttyUSB0@230400", or "tcp:HOST:PORT" of a serial server.
    #[modulation(default = "", fixed)]
    port: Modulation<Text<256>>,
    /// Beams of a scan, over the whole turn. Of several points at a beam, the nearest counts.
    #[modulation(default = 450, min = 90, max = 1088, fixed)]
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
    scanner: Option<Scanner<LdSession>>,
}

impl Schema for Ld {
    fn awake(&mut self, cx: &Context) -> Result {
        cx.require_real_time()?;
        if self.scanner.is_none() {
            let inverted = self.inverted.get(cx);
            let config = LdConfig {
                beams: self.beams.get(cx) as usize,
                inverted,
            };
            self.scanner = Some(Scanner::new(self.address(cx)?, config, inverted));
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

impl Ld {
    fn address(&self, cx: &Context) -> Result<Address> {
        scanner::address(&self.port.get(cx), "serial:/dev/ttyUSB0@230400")
    }
}

impl Inspect for Ld {
    fn inspect(&self, cx: &Context, problems: &mut Problems) {
        inspect_port(&self.port, self.address(cx), problems);
    }
}

#[cfg(test)]
mod tests;
