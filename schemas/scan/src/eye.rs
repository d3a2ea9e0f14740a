//! What a laser has looked at: as far as its beams go, and nowhere else.

use core::f64::consts::TAU;

use jde_motion::Sweep;
use jde_schema::types::{LaserScan, Point2D, Pose2D, normalize_angle};

/// What is so much farther than the end of a beam is not seen by it, m: more than the noise of a range, and than the
/// motion within a scan moves its end.
const TOLERANCE: f64 = 0.1;

/// The beams of one scan, in the frame of the odometry.
#[derive(Debug)]
pub(crate) struct Eye {
    /// Where the laser was in the middle of the scan.
    pose: Pose2D,
    /// The angle of the first beam and the angle from beam to beam, rad.
    angle_min: f64,
    increment: f64,
    /// How far each beam goes, m; 0 of one that measures nothing.
    lengths: Vec<f32>,
}

impl Eye {
    /// Returns the beams of a scan of a laser at `mount`.
    pub(crate) fn new(scan: &LaserScan, sweep: &Sweep, mount: &Pose2D) -> Self {
        let mut lengths = vec![0.0; scan.ranges.len()];
        for (beam, length, _) in scan.lengths() {
            lengths[beam] = length;
        }
        Self {
            pose: sweep.middle().transform(mount),
            angle_min: f64::from(scan.angle_min),
            increment: f64::from(scan.angle_increment),
            lengths,
        }
    }

    /// Returns whether the beam in the direction of a place goes as far as that, or as the thing that it shows there.
    pub(crate) fn sees(&self, place: &Point2D) -> bool {
        let (dx, dy) = (place.x - self.pose.x, place.y - self.pose.y);
        let angle = dy.atan2(dx) - self.pose.theta;
        self.beam(angle)
            .is_some_and(|length| length > 0.0 && dx.hypot(dy) <= length + TOLERANCE)
    }

    /// Returns how far the beam nearest to a direction goes, m; `None` if the view does not reach there.
    fn beam(&self, angle: f64) -> Option<f64> {
        let count = self.lengths.len();
        let last = count.saturating_sub(1) as f64;
        // From the middle of the view, no direction of it is more than half a turn away.
        let middle = self.angle_min + self.increment * last / 2.0;
        let mut beam = (normalize_angle(angle - middle) / self.increment + last / 2.0).round();
        if self.increment.abs() * (count as f64 + 0.5) > TAU {
            beam = beam.rem_euclid(count as f64);
        }
        // The increment of a single beam may be 0, and the quotient none.
        let is_inside = beam >= 0.0 && beam < count as f64;
        is_inside.then(|| f64::from(self.lengths[beam as usize]))
    }
}
