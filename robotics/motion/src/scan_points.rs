//! The points that a laser sees, in the frame of the base. A scan that is none is refused, because nothing tells it
//! from a free space.

use jde_types::{LaserScan, Point2D, Pose2D, Unmeasured};

use crate::history::end;

/// The points of one scan; it keeps its memory from one scan to the next.
#[derive(Clone, Debug, Default)]
pub struct ScanPoints {
    points: Vec<Point2D>,
}

impl ScanPoints {
    /// Replaces the points by those of `scan`, of a laser that was at `laser` at each beam.
    ///
    /// # Errors
    /// As [`LaserScan::measured`], or if a pose of the laser is not finite. Then there are none.
    pub fn update(&mut self, scan: &LaserScan, laser: impl Fn(usize) -> Pose2D) -> Result<(), Unmeasured> {
        self.points.clear();
        scan.measured()?;
        let points = scan.points();
        self.points
            .extend(points.map(|point| end(&laser(point.beam), point.angle, point.range)));
        if !(self.points.iter()).all(|point| point.x.is_finite() && point.y.is_finite()) {
            self.points.clear();
            return Err(Unmeasured::NotFinite);
        }
        Ok(())
    }

    /// Returns the points, in the order of the beams.
    #[must_use]
    pub fn as_slice(&self) -> &[Point2D] {
        &self.points
    }
}

#[cfg(test)]
mod tests {
    use core::f64::consts::FRAC_PI_2;

    use super::*;

    fn scan(ranges: &[f32]) -> LaserScan {
        let mut scan = LaserScan {
            angle_increment: FRAC_PI_2 as f32,
            range_min: 0.1,
            range_max: 8.0,
            ..LaserScan::default()
        };
        scan.ranges.extend_from_slice(ranges).expect("few beams");
        scan.state_last_angle();
        scan
    }

    #[test]
    fn points_are_in_the_frame_of_the_base() {
        let mut scan_points = ScanPoints::default();
        scan_points
            .update(&scan(&[1.0, 2.0]), |_| Pose2D::new(0.2, 0.1, FRAC_PI_2))
            .expect("it measures");
        let [ahead, left] = scan_points.as_slice() else {
            panic!("two points")
        };
        assert!((ahead.x - 0.2).abs() < 1e-6 && (ahead.y - 1.1).abs() < 1e-6);
        assert!((left.x + 1.8).abs() < 1e-6 && (left.y - 0.1).abs() < 1e-6);
    }

    #[test]
    fn by_rep_117_infinity_is_free_and_minus_infinity_is_as_close_as_the_least_range() {
        let mut scan_points = ScanPoints::default();
        let ranges = [f32::NEG_INFINITY, f32::INFINITY, f32::NAN];
        scan_points
            .update(&scan(&ranges), |_| Pose2D::ORIGIN)
            .expect("it measures");
        assert_eq!(scan_points.as_slice().len(), 1);
        assert!((scan_points.as_slice()[0].x - 0.1).abs() < 1e-6);
    }

    #[test]
    fn a_scan_without_a_measurement_is_blind_and_keeps_no_old_points() {
        let mut scan_points = ScanPoints::default();
        scan_points
            .update(&scan(&[1.0]), |_| Pose2D::ORIGIN)
            .expect("it measures");
        assert_eq!(
            scan_points.update(&scan(&[]), |_| Pose2D::ORIGIN),
            Err(Unmeasured::Nothing)
        );
        assert!(scan_points.as_slice().is_empty());
        assert_eq!(
            scan_points.update(&scan(&[f32::NAN; 3]), |_| Pose2D::ORIGIN),
            Err(Unmeasured::Nothing)
        );
        assert_eq!(
            scan_points.update(&scan(&[1.0]), |_| Pose2D::new(f64::NAN, 0.0, 0.0)),
            Err(Unmeasured::NotFinite)
        );
        assert_eq!(
            scan_points.update(&scan(&[f32::INFINITY]), |_| Pose2D::ORIGIN),
            Ok(())
        );
    }
}
