//! Converts laser scans of ROS 2, with any number of beams, to the bounded scans of schemas: adjacent beams
//! are replaced by their nearest, so that no obstacle is lost.

use jde_schema::prelude::*;
use jde_schema::types::{Echo, Unmeasured, check_beams};

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
    /// Writes this scan into `scan`. The scanner is turned by `yaw` rad to the left in its frame.
    ///
    /// # Errors
    /// Why it is no scan.
    pub(crate) fn fill(&self, yaw: f32, scan: &mut LaserScan) -> Result<(), Unmeasured> {
        let angles = [self.angle_min, self.angle_max, self.angle_increment];
        check_beams(angles, [self.range_min, self.range_max], &self.ranges)?;
        let group_size = self.ranges.len().div_ceil(Seq::<f32, 1088>::CAPACITY).max(1);
        let size = group_size as f32;
        scan.header = self.header;
        scan.angle_min = self.angle_min + yaw + self.angle_increment * (size - 1.0) / 2.0;
        scan.angle_increment = self.angle_increment * size;
        scan.time_increment = self.time_increment * size;
        scan.scan_time = self.scan_time;
        scan.range_min = self.range_min;
        scan.range_max = self.range_max;
        scan.ranges.clear();
        scan.intensities.clear();
        for (group, ranges) in self.ranges.chunks(group_size).enumerate() {
            let (nearest, range) = self.nearest(ranges);
            // The size of the groups ensures that they fit.
            let _ = scan.ranges.push(range);
            if let Some(intensity) = self.intensities.get(group * group_size + nearest) {
                let _ = scan.intensities.push(*intensity);
            }
        }
        scan.state_last_angle();
        Ok(())
    }

    /// Returns the nearest of these ranges and its index. Those of objects precede others.
    fn nearest(&self, ranges: &[f32]) -> (usize, f32) {
        let rank = |range: f32| match Echo::of(range, self.range_min, self.range_max) {
            Echo::Hit(_) | Echo::TooClose => 0,
            Echo::Free => 1,
            Echo::Nothing => 2,
        };
        let order = |a: &(usize, &f32), b: &(usize, &f32)| {
            rank(*a.1).cmp(&rank(*b.1)).then_with(|| a.1.total_cmp(b.1))
        };
        let nearest = ranges.iter().enumerate().min_by(order);
        nearest.map_or((0, f32::NAN), |(index, range)| (index, *range))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
        sweep.fill(0.0, &mut scan).unwrap();
        assert_eq!(scan.ranges.as_slice(), [1.0, f32::INFINITY, 0.0]);
        assert_eq!(scan.intensities.as_slice(), [5.0, 6.0, 7.0]);
        assert_eq!((scan.angle_min, scan.angle_increment), (-1.0, 0.001));
        assert!((scan.angle_max + 0.998).abs() < 1e-6);
        sweep.fill(0.5, &mut scan).unwrap();
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
        sweep(&ranges).fill(0.0, &mut scan).unwrap();
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
        sweep(&ranges).fill(0.0, &mut scan).unwrap();
        assert_eq!(scan.ranges.len(), 545);
        assert_eq!(scan.ranges[0], f32::INFINITY);
        assert!(scan.ranges[1].is_nan());
    }

    #[test]
    fn a_scan_that_is_none_is_refused() {
        let mut invalid = sweep(&[1.0; 2000]);
        assert_eq!(invalid.fill(0.0, &mut LaserScan::default()), Ok(()));
        invalid.angle_max = 3.0;
        let refused = invalid.fill(0.0, &mut LaserScan::default());
        assert!(
            matches!(refused, Err(Unmeasured::Beams { found: 2000, .. })),
            "{refused:?}"
        );
        let zeros = sweep(&[0.0; 2000]).fill(0.0, &mut LaserScan::default());
        assert_eq!(zeros, Err(Unmeasured::Nothing));
    }
}
