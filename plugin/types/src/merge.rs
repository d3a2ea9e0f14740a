//! Scans of more beams than fit: adjacent beams become the nearest of them, so that no obstacle is lost.

use crate::{Echo, Header, LaserScan, Seq, Unmeasured, check_beams};

/// The scan of another program, with any number of beams. Its fields are those of [`LaserScan`].
#[derive(Clone, Copy, Debug)]
pub struct Beams<'a> {
    /// Time, and the frame of the scanner.
    pub header: Header,
    /// The first and the last angle, and the angle from one beam to the next, rad.
    pub angles: [f32; 3],
    /// The time from one beam to the next, s.
    pub time_increment: f32,
    /// The time from one scan to the next, s.
    pub scan_time: f32,
    /// The least and the greatest measurable distance, m.
    pub limits: [f32; 2],
    /// Distances, in the order of the beams, m.
    pub ranges: &'a [f32],
    /// Intensities; empty if there are none.
    pub intensities: &'a [f32],
}

impl Beams<'_> {
    /// Writes the scan into `scan`. The scanner is turned by `yaw` rad to the left in its frame.
    ///
    /// # Errors
    /// Why it is no scan.
    pub fn write_to(&self, yaw: f32, scan: &mut LaserScan) -> Result<(), Unmeasured> {
        check_beams(self.angles, self.limits, self.ranges)?;
        let [first, _, increment] = self.angles;
        let group_size = self.ranges.len().div_ceil(Seq::<f32, 1088>::CAPACITY).max(1);
        let size = group_size as f32;
        scan.header = self.header;
        scan.angle_min = first + yaw + increment * (size - 1.0) / 2.0;
        scan.angle_increment = increment * size;
        scan.time_increment = self.time_increment * size;
        scan.scan_time = self.scan_time;
        [scan.range_min, scan.range_max] = self.limits;
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
        let [least, greatest] = self.limits;
        let rank = |range: f32| match Echo::of(range, least, greatest) {
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
