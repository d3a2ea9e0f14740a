//! Drives Hokuyo laser scanners that use SCIP 2. The modules of the protocol do no I/O; this file connects
//! them to a port, a clock and the exports.

mod clock;
#[cfg(test)]
mod emulator;
mod message;
mod scan;
mod session;

use core::f64::consts::TAU;

use jde_device::port::{Address, Backoff, Port};
use jde_device::{Device, inspect_port};
use jde_schema::prelude::*;

use clock::Clock;
use scan::{Beams, Letters, Scan};
use session::{ScannerConfig, ScannerData, Session};

/// A Hokuyo laser scanner (URG, UBG, UTM, UST, UXM) at a serial line, over USB or over Ethernet.
///
/// The driver reads the scanner's parameters, starts it, and reconnects by itself after every loss.
#[derive(Describe)]
#[schema(driver, period = "10ms", budget = "20ms")]
pub struct Scip2 {
    /// Its address: "tcp:192.168.0.10:10940", or "serial:/dev/ttyACM0@115200".
    #[modulation(default = "", fixed)]
    port: Modulation<Text<256>>,
    /// The angle to cover, centred ahead; limited to that of the scanner.
    #[modulation(default = TAU, unit = "rad", min = 0.0, max = TAU, fixed)]
    view: Modulation<f64>,
    /// Turns skipped between two scans.
    #[modulation(default = 0, max = 9, fixed)]
    skip: Modulation<u32>,
    /// Letters per distance: 3, or 2 for distances up to 4.094 m over slow lines.
    #[modulation(default = 3, min = 2, max = 3, fixed)]
    letters: Modulation<u32>,
    /// The scan, from right to left.
    #[export(validity = "1s")]
    laser: Export<LaserScan>,
    /// Whether the scanner is connected.
    #[export(lasting)]
    connection: Export<Connection>,
    scanner: Option<Scanner>,
}

/// A scanner that the driver is looking for or has found.
struct Scanner {
    device: Device<Session>,
    clock: Clock,
    beams: Option<Beams>,
    /// Whether `laser` has a value.
    has_scan: bool,
}

impl Schema for Scip2 {
    fn awake(&mut self, cx: &Context) -> Result {
        cx.require_real_time()?;
        if self.scanner.is_none() {
            self.scanner = Some(self.scanner(cx)?);
        }
        Ok(())
    }

    fn iterate(&mut self, cx: &Context) -> Result {
        let Some(scanner) = &mut self.scanner else {
            return Err("it is not awake".into());
        };
        for data in scanner.device.step(cx) {
            match data {
                ScannerData::Beams(beams) => {
                    info!(cx, "{} beams", beams.count());
                    (scanner.clock, scanner.beams) = (Clock::default(), Some(beams));
                }
                ScannerData::Scan(scan) => scanner.publish(cx, &mut self.laser, &scan)?,
            }
        }
        if !scanner.device.is_ready() && scanner.has_scan {
            scanner.has_scan = false;
            self.laser.retract(cx);
        }
        scanner.device.export_connection(cx, &mut self.connection);
        Ok(())
    }

    fn sleep(&mut self, cx: &Context) {
        if let Some(scanner) = self.scanner.take() {
            scanner.device.close(cx, &mut self.connection);
            self.laser.retract(cx);
        }
    }
}

impl Scip2 {
    fn scanner(&self, cx: &Context) -> Result<Scanner> {
        let address = self.address(cx)?;
        let baud = match address {
            Address::Serial { baud, .. } => Some(baud),
            Address::Tcp { .. } => None,
        };
        let config = ScannerConfig {
            view: self.view.get(cx),
            skip: self.skip.get(cx),
            letters: match self.letters.get(cx) {
                2 => Letters::Two,
                _ => Letters::Three,
            },
            baud,
        };
        let port = Port::new(address, Backoff::default());
        Ok(Scanner {
            device: Device::new(port, config),
            clock: Clock::default(),
            beams: None,
            has_scan: false,
        })
    }

    fn address(&self, cx: &Context) -> Result<Address> {
        let address = self.port.get(cx);
        if address.is_empty() {
            return Err(
                "it has no port; give it one in the application: port = \"tcp:192.168.0.10:10940\", \
                 or port = \"serial:/dev/ttyACM0@115200\""
                    .into(),
            );
        }
        match Address::parse(address.as_str())? {
            fast @ Address::Serial { baud, .. } if baud > 999_999 => {
                Err(format!("{fast}: a scanner's line goes at 750000 baud at most").into())
            }
            address @ (Address::Serial { .. } | Address::Tcp { .. }) => Ok(address),
        }
    }
}

impl Inspect for Scip2 {
    fn inspect(&self, cx: &Context, problems: &mut Problems) {
        inspect_port(&self.port, self.address(cx), problems);
    }
}

impl Scanner {
    fn publish(&mut self, cx: &Context, export: &mut Export<LaserScan>, scan: &Scan) -> Result {
        let Some(beams) = self.beams else {
            return Ok(());
        };
        let time = self.clock.measured(scan.stamp, cx.now());
        let mut laser = export.loan(cx);
        laser.header = Header::new(time, "laser");
        laser.angle_min = beams.angle_min();
        laser.angle_increment = beams.increment();
        laser.angle_max = beams.angle_min() + beams.increment() * (beams.count() - 1) as f32;
        laser.time_increment = beams.time_increment();
        laser.scan_time = beams.scan_time();
        laser.range_min = beams.range_min();
        laser.range_max = beams.range_max();
        laser.intensities.clear();
        laser.ranges.clear();
        laser.ranges.extend_from_slice(&scan.ranges)?;
        laser.publish_at(time);
        self.has_scan = true;
        Ok(())
    }
}

jde_schema::export!("hokuyo", "Drives Hokuyo laser scanners that use SCIP 2.", [Scip2]);

#[cfg(test)]
mod tests;
