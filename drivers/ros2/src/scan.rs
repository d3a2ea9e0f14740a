//! Laser scans of ROS 2, which have any number of beams, as the bounded scans of schemas.

use jde_schema::prelude::*;
use jde_schema::types::{Beams, Unmeasured};

/// A scan of up to 16384 beams.
#[derive(Clone, Copy, Debug, Value)]
#[repr(C)]
#[value(name = "sensor_msgs/msg/LaserScan")]
pub(crate) struct Sweep {
    pub(crate) header: Header,
    pub(crate) angle_min: f32,
    pub(crate) angle_max: f32,
    pub(crate) angle_increment: f32,
    pub(crate) time_increment: f32,
    pub(crate) scan_time: f32,
    pub(crate) range_min: f32,
    pub(crate) range_max: f32,
    pub(crate) ranges: Seq<f32, 16384>,
    pub(crate) intensities: Seq<f32, 16384>,
}

impl Sweep {
    /// Writes this scan into `scan`.
    ///
    /// # Errors
    /// Why it is no scan.
    pub(crate) fn fill(&self, reading: Reading, scan: &mut LaserScan) -> Result<(), Unmeasured> {
        let beams = Beams {
            header: self.header,
            angles: [self.angle_min, self.angle_max, self.angle_increment],
            time_increment: self.time_increment,
            scan_time: self.scan_time,
            limits: [self.range_min, self.range_max],
            ranges: &self.ranges,
            intensities: &self.intensities,
        };
        beams.write_to(reading.yaw, scan)?;
        if !reading.inf_is_valid {
            scan.remove_free();
        }
        scan.measured()
    }
}

/// How the scans of a scanner are read.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Reading {
    /// By how far the scanner is turned to the left in its frame, rad.
    pub(crate) yaw: f32,
    /// Whether +∞ and the greatest distance say that nothing is within reach. Many drivers say them also where no return came
    /// back, so that they say nothing.
    pub(crate) inf_is_valid: bool,
}

#[cfg(test)]
mod tests {
    use super::*;

    const VALID: Reading = Reading {
        yaw: 0.0,
        inf_is_valid: true,
    };

    #[test]
    fn a_beam_without_a_return_says_nothing_unless_its_driver_means_that_nothing_is_there() {
        let mut scan = LaserScan::default();
        let sweep = sweep(&[1.0, f32::INFINITY, 10.0, f32::NEG_INFINITY]);
        sweep.fill(VALID, &mut scan).unwrap();
        assert_eq!(scan.lengths().count(), 3);
        sweep.fill(Reading::default(), &mut scan).unwrap();
        assert!(scan.ranges[1].is_nan() && scan.ranges[2].is_nan());
        assert_eq!((scan.ranges[0], scan.ranges[3]), (1.0, f32::NEG_INFINITY));
        assert_eq!(scan.lengths().collect::<Vec<_>>(), [(0, 1.0, true)]);
    }

    #[test]
    fn a_scan_in_which_nothing_returned_is_none() {
        let sweep = sweep(&[f32::INFINITY; 100]);
        let mut scan = LaserScan::default();
        assert_eq!(sweep.fill(VALID, &mut scan), Ok(()));
        assert_eq!(
            sweep.fill(Reading::default(), &mut scan),
            Err(Unmeasured::Nothing)
        );
    }

    fn sweep(ranges: &[f32]) -> Box<Sweep> {
        let mut sweep = Box::new(Sweep::zeroed());
        sweep.angle_min = -1.0;
        sweep.angle_increment = 0.001;
        sweep.range_min = 0.1;
        sweep.range_max = 10.0;
        sweep.ranges.extend_from_slice(ranges).unwrap();
        sweep.angle_max = -1.0 + 0.001 * (ranges.len() - 1) as f32;
        sweep
    }

    #[test]
    fn a_scan_that_fits_is_copied_unchanged() {
        let mut scan = LaserScan::default();
        let mut sweep = sweep(&[1.0, f32::INFINITY, 0.0]);
        sweep.intensities.extend_from_slice(&[5.0, 6.0, 7.0]).unwrap();
        sweep.fill(VALID, &mut scan).unwrap();
        assert_eq!(scan.ranges.as_slice(), [1.0, f32::INFINITY, 0.0]);
        assert_eq!(scan.intensities.as_slice(), [5.0, 6.0, 7.0]);
        assert_eq!((scan.angle_min, scan.angle_increment), (-1.0, 0.001));
        assert!((scan.angle_max + 0.998).abs() < 1e-6);
        sweep.fill(Reading { yaw: 0.5, ..VALID }, &mut scan).unwrap();
        assert_eq!(scan.angle_min, -0.5);
    }

    #[test]
    fn too_many_beams_are_reduced_to_the_nearest_of_each_group() {
        let mut ranges = vec![5.0_f32; 2000];
        ranges[1000] = f32::NAN;
        ranges[1001] = 2.0;
        ranges[10] = f32::NEG_INFINITY;
        ranges[20] = 0.05;
        ranges[1999] = 1.0;
        let mut scan = LaserScan::default();
        sweep(&ranges).fill(VALID, &mut scan).unwrap();
        assert_eq!(scan.ranges.len(), 1000);
        assert_eq!((scan.ranges[500], scan.ranges[999]), (2.0, 1.0));
        assert_eq!(scan.ranges[5], f32::NEG_INFINITY);
        assert_eq!(scan.ranges[10], 5.0, "a range below the minimum was not measured");
        let angle = scan.angle(500);
        assert!((angle - (-1.0 + 1000.5 * 0.001)).abs() < 1e-4, "{angle}");
    }

    #[test]
    fn groups_with_an_infinite_range_are_free_rather_than_unknown() {
        let mut ranges = vec![f32::NAN; 1089];
        ranges[1] = f32::INFINITY;
        let mut scan = LaserScan::default();
        sweep(&ranges).fill(VALID, &mut scan).unwrap();
        assert_eq!(scan.ranges.len(), 545);
        assert_eq!(scan.ranges[0], f32::INFINITY);
        assert!(scan.ranges[1].is_nan());
    }

    #[test]
    fn a_scan_that_is_none_is_refused() {
        let mut invalid = sweep(&[1.0; 2000]);
        assert_eq!(invalid.fill(VALID, &mut LaserScan::default()), Ok(()));
        invalid.angle_max = 3.0;
        let refused = invalid.fill(VALID, &mut LaserScan::default());
        assert!(
            matches!(refused, Err(Unmeasured::Beams { found: 2000, .. })),
            "{refused:?}"
        );
        let zeros = sweep(&[0.0; 2000]).fill(VALID, &mut LaserScan::default());
        assert_eq!(zeros, Err(Unmeasured::Nothing));
    }
}
