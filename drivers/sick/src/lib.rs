//! Drives SICK LMS 200, 211, 220, 221 and 291 laser scanners. The modules of the protocol do no I/O; this
//! file connects them to a port, a clock and the exports.

#[cfg(test)]
mod emulator;
mod scan;
mod session;
mod telegram;

use core::time::Duration;

use jde_device::port::{Address, Backoff, Port};
use jde_device::{Device, inspect_port};
use jde_schema::prelude::*;

use scan::{Beams, Reach};
use session::{Scan, ScannerConfig, SerialSpeed, Session};

/// Time of one turn of the mirror, s: 75 turns per second.
const TURN: f32 = 1.0 / 75.0;

/// A SICK LMS 2xx laser scanner at a serial line, or behind a serial server.
///
/// The driver finds the scanner at any of its speeds, configures it, and reconnects by itself after every
/// loss.
#[derive(Describe)]
#[schema(driver, period = "10ms", budget = "20ms")]
pub struct Lms2xx {
    /// Its address: "serial:/dev/ttyUSB0@9600", or "tcp:HOST:PORT" of a serial server.
    #[modulation(default = "", fixed)]
    port: Modulation<Text<256>>,
    /// Speed of the line while scans arrive, bits per second: 9600, 19200, 38400, or 500000 over RS-422.
    #[modulation(default = 38_400, fixed)]
    baud: Modulation<u32>,
    /// Beams of a scan: 181 or 361 over half a turn, 101, 201 or 401 over 100 degrees.
    #[modulation(default = 181, fixed)]
    beams: Modulation<u32>,
    /// Greatest distance: 8, 16 or 32 with a resolution of millimetres, 80 with centimetres.
    #[modulation(default = 8, unit = "m", fixed)]
    reach: Modulation<u32>,
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
    /// Time at which the exported scan was measured; `None` before the first scan and after a loss.
    last_scan: Option<Duration>,
}

impl Schema for Lms2xx {
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
        for scan in scanner.device.step(cx) {
            scanner.publish(cx, &mut self.laser, &scan)?;
        }
        if !scanner.device.is_ready() && scanner.last_scan.take().is_some() {
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

impl Lms2xx {
    fn scanner(&self, cx: &Context) -> Result<Scanner> {
        let address = self.address(cx)?;
        let baud = self.working_baud(cx)?;
        let speed = match address {
            Address::Serial { baud: first, .. } => SerialSpeed::Serial { first, working: baud },
            Address::Tcp { .. } => SerialSpeed::Fixed,
        };
        let config = ScannerConfig {
            beams: self.scan(cx)?,
            reach: self.reach(cx)?,
            speed,
        };
        let port = Port::new(address, Backoff::default());
        Ok(Scanner {
            device: Device::new(port, config),
            last_scan: None,
        })
    }

    fn address(&self, cx: &Context) -> Result<Address> {
        let address = self.port.get(cx);
        if address.is_empty() {
            return Err(
                "it has no port; give it one in the application: port = \"serial:/dev/ttyUSB0@9600\"".into(),
            );
        }
        Ok(Address::parse(address.as_str())?)
    }

    /// Speed of the line while scans arrive, baud.
    fn working_baud(&self, cx: &Context) -> Result<u32> {
        match self.baud.get(cx) {
            baud @ (9600 | 19_200 | 38_400 | 500_000) => Ok(baud),
            baud => Err(format!("baud = {baud}: it can be 9600, 19200, 38400 or 500000").into()),
        }
    }

    fn scan(&self, cx: &Context) -> Result<Beams> {
        let beams = self.beams.get(cx);
        Beams::with_count(beams)
            .ok_or_else(|| format!("beams = {beams}: it can be 101, 181, 201, 361 or 401").into())
    }

    fn reach(&self, cx: &Context) -> Result<Reach> {
        let reach = self.reach.get(cx);
        Reach::metres(reach).ok_or_else(|| format!("reach = {reach}: it can be 8, 16, 32 or 80").into())
    }
}

impl Inspect for Lms2xx {
    fn inspect(&self, cx: &Context, problems: &mut Problems) {
        inspect_port(&self.port, self.address(cx), problems);
        problems.expect(&self.baud, self.working_baud(cx));
        problems.expect(&self.beams, self.scan(cx));
        problems.expect(&self.reach, self.reach(cx));
    }
}

impl Scanner {
    fn publish(&mut self, cx: &Context, export: &mut Export<LaserScan>, scan: &Scan) -> Result {
        let beams = self.device.config().beams;
        // The time of the first beam: before the rest of the turn, and before the transfer of the scan.
        let turn = Duration::from_secs_f32(TURN * f32::from(beams.view) / 360.0);
        let time = cx.now().saturating_sub(scan.transfer + turn);
        let time = self.last_scan.map_or(time, |last| time.max(last));
        let mut laser = export.loan(cx);
        laser.header = Header::new(time, "laser");
        laser.angle_min = beams.angle_min();
        laser.angle_increment = beams.increment();
        laser.angle_max = beams.angle_min() + beams.increment() * (beams.count() - 1) as f32;
        // Steps below one degree combine several turns, in an order that one number cannot describe.
        laser.time_increment = if beams.step == 100 { TURN / 360.0 } else { 0.0 };
        laser.scan_time = self.last_scan.map_or(0.0, |last| (time - last).as_secs_f32());
        laser.range_min = 0.0;
        laser.range_max = self.device.config().reach.range_max();
        laser.intensities.clear();
        laser.ranges.clear();
        laser.ranges.extend_from_slice(&scan.ranges)?;
        laser.publish_at(time);
        self.last_scan = Some(time);
        Ok(())
    }
}

jde_schema::export!("sick", "Drives SICK LMS laser scanners.", [Lms2xx]);

#[cfg(test)]
mod tests;
