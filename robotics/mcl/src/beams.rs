//! The beams of a scan that count: evenly chosen among those that hit something.

use jde_types::{Echo, LaserScan, Pose2D, Unmeasured};

/// The fewest hits that say where a robot is.
const MIN_HITS: usize = 8;

/// Why a scan cannot be used.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum Blind {
    /// So few beams hit something: there are no more, or most are NaN or infinite.
    #[error("only {0} beams of the laser hit something: a pose needs {MIN_HITS}")]
    Few(usize),
    /// The scan is none.
    #[error("the scan of the laser is none: {0}")]
    NoScan(Unmeasured),
    /// The place of the scanner is not finite.
    #[error("the mount of the laser is not finite")]
    NotFinite,
}

/// A beam, in the frame of the base.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Beam {
    /// Where it ends, m.
    pub(crate) end: (f32, f32),
    /// Its direction: cosine and sine.
    pub(crate) direction: (f32, f32),
    /// Its length, m.
    pub(crate) range: f32,
}

/// The beams of one scan; it keeps its memory from one scan to the next.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Beams {
    /// How many there may be.
    most: usize,
    beams: Vec<Beam>,
    /// Where they begin, m.
    mount: (f32, f32),
}

impl Beams {
    /// Returns room for `most` beams.
    #[must_use]
    pub fn new(most: usize) -> Self {
        Self {
            most,
            beams: Vec::with_capacity(most),
            mount: (0.0, 0.0),
        }
    }

    /// Replaces the beams by those of `scan`, of a scanner that is at `laser` at each beam, in the frame of the base: as many
    /// as there is room for, evenly chosen among those that hit something.
    ///
    /// # Errors
    /// If fewer than eight beams do, the scan is none, or the place of the scanner is not finite. Then there are none.
    pub fn update(&mut self, scan: &LaserScan, laser: impl Fn(usize) -> Pose2D) -> Result<(), Blind> {
        self.beams.clear();
        let mount = laser(0);
        self.mount = (mount.x as f32, mount.y as f32);
        let all = || {
            scan.echoes()
                .filter_map(|(beam, echo)| hit(echo).map(|range| (beam, range)))
        };
        let hits = all().count();
        if !mount.is_finite() {
            return Err(Blind::NotFinite);
        }
        match scan.measured() {
            Ok(()) | Err(Unmeasured::Nothing) => {}
            Err(why) => return Err(Blind::NoScan(why)),
        }
        if hits < MIN_HITS {
            return Err(Blind::Few(hits));
        }
        let most = self.most.min(hits);
        for (number, (beam, range)) in all().enumerate() {
            // Of every `hits / most` the first.
            if number * most / hits == self.beams.len() {
                let from = laser(beam);
                let (sin, cos) = libm::sincos(from.theta + scan.angle(beam));
                let (cos, sin) = (cos as f32, sin as f32);
                self.beams.push(Beam {
                    end: (from.x as f32 + range * cos, from.y as f32 + range * sin),
                    direction: (cos, sin),
                    range,
                });
            }
        }
        Ok(())
    }

    /// Takes over an even selection of `others`, as many as there is room for.
    pub(crate) fn thin(&mut self, others: &Self) {
        self.beams.clear();
        self.mount = others.mount;
        let step = others.beams.len().div_ceil(self.most.max(1)).max(1);
        self.beams.extend(others.beams.iter().step_by(step));
    }

    /// The beams.
    pub(crate) fn as_slice(&self) -> &[Beam] {
        &self.beams
    }

    /// Where they begin, m.
    pub(crate) const fn mount(&self) -> (f32, f32) {
        self.mount
    }
}

fn hit(echo: Echo) -> Option<f32> {
    match echo {
        Echo::Hit(range) => Some(range),
        Echo::TooClose | Echo::Free | Echo::Nothing => None,
    }
}

#[cfg(test)]
mod tests {
    use core::f64::consts::FRAC_PI_2;

    use super::*;

    fn scan(ranges: &[f32]) -> LaserScan {
        let mut scan = LaserScan {
            angle_increment: 0.02,
            range_min: 0.1,
            range_max: 8.0,
            ..LaserScan::default()
        };
        scan.ranges.extend_from_slice(ranges).expect("few beams");
        scan.state_last_angle();
        scan
    }

    #[test]
    fn scans_that_say_too_little_are_refused() {
        let mut beams = Beams::new(60);
        let mount = |_| Pose2D::ORIGIN;
        for (ranges, hits) in [
            (&[][..], 0),
            (&[f32::NAN; 300], 0),
            (&[f32::INFINITY; 300], 0),
            (&[f32::NEG_INFINITY; 300], 0),
            (&[0.05; 300], 0),
            (&[8.0; 300], 0),
            (&[9.0; 300], 0),
            (&[1.0; 7], 7),
        ] {
            beams.update(&scan(&[1.0; 9]), mount).expect("enough");
            assert_eq!(beams.update(&scan(ranges), mount), Err(Blind::Few(hits)));
            assert!(beams.as_slice().is_empty(), "none of the scan before");
        }
        let nowhere = Pose2D::new(0.0, f64::NAN, 0.0);
        assert_eq!(beams.update(&scan(&[1.0; 9]), |_| nowhere), Err(Blind::NotFinite));
        let turned = LaserScan {
            angle_increment: f32::NAN,
            ..scan(&[1.0; 9])
        };
        assert_eq!(
            beams.update(&turned, mount),
            Err(Blind::NoScan(Unmeasured::Angles))
        );
    }

    #[test]
    fn beams_are_chosen_evenly_among_the_hits() {
        let mut ranges = [f32::NAN; 100];
        ranges.iter_mut().step_by(2).for_each(|range| *range = 2.0);
        let mut beams = Beams::new(10);
        beams.update(&scan(&ranges), |_| Pose2D::ORIGIN).expect("enough");
        let angles: Vec<f32> = beams
            .as_slice()
            .iter()
            .map(|beam| beam.direction.0.acos())
            .collect();
        assert_eq!(angles.len(), 10);
        assert!(
            (angles[1] - angles[0] - 0.2).abs() < 1e-3,
            "of every five hits one"
        );
        let mut few = Beams::new(4);
        few.thin(&beams);
        assert_eq!(few.as_slice().len(), 4);
    }

    #[test]
    fn ends_are_in_the_frame_of_the_base() {
        let mut beams = Beams::new(60);
        let mount = Pose2D::new(0.2, 0.1, FRAC_PI_2);
        beams.update(&scan(&[1.0; 8]), |_| mount).expect("enough");
        let first = beams.as_slice()[0];
        assert!((first.end.0 - 0.2).abs() < 1e-6 && (first.end.1 - 1.1).abs() < 1e-6);
    }
}
