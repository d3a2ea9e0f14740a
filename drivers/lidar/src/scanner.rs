//! What the drivers of all lidars share: a lidar at a port, whose turns are exported as scans. It knows no protocol.

use core::f32::consts::{PI, TAU};
use core::time::Duration;

use jde_device::port::{Address, Backoff, Port};
use jde_device::{Device, Protocol};
use jde_schema::prelude::*;

use crate::turn::Turn;

/// A turn, as a session gives it to the driver.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Scan {
    pub(crate) turn: Turn,
    /// How long before this reading its last point was measured.
    pub(crate) age: Duration,
    /// The least and the greatest measurable distance, m.
    pub(crate) limits: [f32; 2],
    /// Whether the lidar measures intensities in this mode.
    pub(crate) has_intensities: bool,
}

/// A lidar that the driver is looking for or has found.
pub(crate) struct Scanner<P: Protocol<Data = Scan>> {
    device: Device<P>,
    inverted: bool,
    /// Time of the oldest point of the exported scan; `None` before the first scan and after a loss.
    last: Option<Duration>,
}

impl<P: Protocol<Data = Scan>> Scanner<P> {
    pub(crate) fn new(address: Address, config: P::Config, inverted: bool) -> Self {
        Self {
            device: Device::new(Port::new(address, Backoff::default()), config),
            inverted,
            last: None,
        }
    }

    /// Exports what has arrived, and retracts the scan of a lidar that is lost.
    pub(crate) fn step(
        &mut self,
        cx: &Context,
        laser: &mut Export<LaserScan>,
        connection: &mut Export<Connection>,
    ) -> Result {
        for scan in self.device.step(cx) {
            self.publish(cx, laser, &scan)?;
        }
        if !self.device.is_ready() && self.last.take().is_some() {
            laser.retract(cx);
        }
        self.device.export_connection(cx, connection);
        Ok(())
    }

    pub(crate) fn close(
        self,
        cx: &Context,
        laser: &mut Export<LaserScan>,
        connection: &mut Export<Connection>,
    ) {
        self.device.close(cx, connection);
        laser.retract(cx);
    }

    fn publish(&mut self, cx: &Context, export: &mut Export<LaserScan>, scan: &Scan) -> Result {
        let duration = Duration::try_from_secs_f64(scan.turn.duration).unwrap_or_default();
        let end = cx.now().saturating_sub(scan.age);
        // Readings have the period of the driver as their resolution, so that turns could seem to overlap.
        let start = end.saturating_sub(duration);
        let start = self.last.map_or(start, |last| start.max(last));
        let beams = scan.turn.ranges.len() as f32;
        // Beams follow each other counter-clockwise, and the lidar rotates clockwise: its last point is the first beam.
        let (first, direction) = if self.inverted { (start, 1.0) } else { (end, -1.0) };
        let mut laser = export.loan(cx);
        laser.header = Header::new(first, "laser");
        laser.angle_min = -PI;
        laser.angle_increment = TAU / beams;
        laser.time_increment = direction * scan.turn.duration as f32 / (beams - 1.0);
        laser.scan_time = scan.turn.duration as f32;
        [laser.range_min, laser.range_max] = scan.limits;
        laser.ranges.clear();
        laser.ranges.extend_from_slice(&scan.turn.ranges)?;
        laser.intensities.clear();
        if scan.has_intensities {
            laser.intensities.extend_from_slice(&scan.turn.intensities)?;
        }
        laser.state_last_angle();
        // A scan is as old as its oldest point.
        laser.publish_at(start);
        self.last = Some(start);
        Ok(())
    }
}

/// Reads the address of a lidar. `example` is the address that a message names.
pub(crate) fn address(port: &Text<256>, example: &str) -> Result<Address> {
    if port.is_empty() {
        return Err(format!("it has no port; give it one in the application: port = \"{example}\"").into());
    }
    Ok(Address::parse(port.as_str())?)
}

/// Returns a distance by REP-117: a lidar gives 0 where it measured nothing.
pub(crate) fn range(metres: f32, [least, greatest]: [f32; 2]) -> f32 {
    if metres == 0.0 {
        f32::NAN
    } else if metres < least {
        f32::NEG_INFINITY
    } else if metres > greatest {
        f32::INFINITY
    } else {
        metres
    }
}
