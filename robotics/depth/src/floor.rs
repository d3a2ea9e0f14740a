//! The scan: in each direction the nearest obstacle or edge, or whether the floor is seen all the way.

use jde_schema::types::LaserScan;

/// Part of the way of which it is known whether its floor was seen, m. It is also the least distance that a scan states.
const CELL: f64 = 0.02;
/// The longest part of the way without a measured place on the floor that still counts as seen, m.
const GAP: f64 = 0.3;
/// The most beams that a `LaserScan` has room for.
const MAX_BEAMS: f64 = 1088.0;

/// What counts. The names are those of ROS's `pointcloud_to_laserscan`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits {
    /// How high the sensor is above the floor, m.
    pub height: f64,
    /// Least height of an obstacle, m. What is lower is floor.
    pub min_height: f64,
    /// Greatest height of an obstacle, m: the robot passes below what is higher.
    pub max_height: f64,
    /// How far below the floor something must be to be a cliff, m.
    pub max_drop: f64,
    /// From where on the floor must be seen, m: the scan says nothing of what is nearer.
    pub range_min: f64,
    /// How far the scan reaches, m.
    pub range_max: f64,
    /// The first direction, rad.
    pub angle_min: f64,
    /// The last direction, rad.
    pub angle_max: f64,
    /// From direction to direction, rad.
    pub angle_increment: f64,
}

/// Why limits are refused.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum LimitsError {
    /// The band of heights is empty.
    #[error("`min_height` is not below `max_height`")]
    Heights,
    /// The scan reaches nowhere.
    #[error("`range_min` is not below `range_max`")]
    Ranges,
    /// There are no directions.
    #[error("`angle_min` is not below `angle_max`")]
    Angles,
    /// There are too many.
    #[error("the scan has {0:.0} beams: expected at most 1088, so raise `angle_increment`")]
    Beams(f64),
}

/// What was seen in one picture or cloud.
#[derive(Clone, Debug)]
pub struct FloorScan {
    limits: Limits,
    beams: Vec<Beam>,
    /// The cells of the way whose floor was seen, beam by beam: up to `range_max`, and what an obstacle there would hide.
    floor: Vec<bool>,
    cells: usize,
}

#[derive(Clone, Copy, Debug)]
struct Beam {
    /// The nearest obstacle, m.
    obstacle: f64,
    /// The nearest place at which a ray goes below the floor, m.
    below: f64,
}

impl Beam {
    const NOTHING: Self = Self {
        obstacle: f64::INFINITY,
        below: f64::INFINITY,
    };
}

impl Limits {
    /// Returns the number of beams.
    ///
    /// # Errors
    /// The limits contradict each other.
    fn beams(&self) -> Result<usize, LimitsError> {
        if self.min_height >= self.max_height {
            return Err(LimitsError::Heights);
        }
        if self.range_min >= self.range_max {
            return Err(LimitsError::Ranges);
        }
        if self.angle_min >= self.angle_max {
            return Err(LimitsError::Angles);
        }
        let beams = ((self.angle_max - self.angle_min) / self.angle_increment + 1e-6).floor() + 1.0;
        if (1.0..=MAX_BEAMS).contains(&beams) {
            Ok(beams as usize)
        } else {
            Err(LimitsError::Beams(beams))
        }
    }

    /// Returns how many cells without floor hide nothing: fewer than those behind the lowest obstacle at this distance,
    /// if it has no depth itself.
    fn hidden(&self, range: f64) -> usize {
        let shadow = if self.height > self.min_height {
            range * self.min_height / (self.height - self.min_height)
        } else {
            GAP
        };
        // Of a shadow, the first and the last cell may be seen in part.
        (shadow / CELL - 2.0).clamp(1.0, GAP / CELL) as usize
    }
}

impl FloorScan {
    /// Nothing was seen.
    ///
    /// # Errors
    /// The limits contradict each other.
    pub fn new(limits: Limits) -> Result<Self, LimitsError> {
        let beams = limits.beams()?;
        let cells = (limits.range_max / CELL).ceil() as usize + limits.hidden(limits.range_max);
        Ok(Self {
            limits,
            beams: vec![Beam::NOTHING; beams],
            floor: vec![false; beams * cells],
            cells,
        })
    }

    /// Adds a point that the sensor measured. One that is not finite says nothing.
    pub fn add(&mut self, [x, y, z]: [f64; 3]) {
        let Limits {
            height,
            min_height,
            max_height,
            max_drop,
            angle_min,
            angle_increment,
            ..
        } = self.limits;
        let (range, place) = (
            libm::hypot(x, y),
            ((libm::atan2(y, x) - angle_min) / angle_increment).round(),
        );
        let is_inside = place >= 0.0 && place < self.beams.len() as f64;
        if !is_inside || !range.is_finite() || !z.is_finite() || z > max_height {
            return;
        }
        let beam = place as usize;
        let Beam { obstacle, below } = &mut self.beams[beam];
        if z >= min_height {
            *obstacle = obstacle.min(range);
        } else if z < -max_drop {
            // Where the ray met no floor.
            *below = below.min(range * height / (height - z));
        } else if let Some(seen) =
            self.floor[beam * self.cells..][..self.cells].get_mut((range / CELL) as usize)
        {
            *seen = true;
        }
    }

    /// Writes the scan. Its origin is that of the points. Returns whether anything is known.
    ///
    /// Its `range_min` is the stated one, or how far the nearest obstacle is if that is nearer: an obstacle is never farther
    /// in the scan than in space, and of what is nearer than `range_min` nothing is said. A beam ends at the nearest obstacle,
    /// or at the last floor before a cliff. If the floor is not seen all the way there, it ends at the last floor before the
    /// gap, and is −∞ if there is none. A beam that ends nowhere is free if the floor is seen from `range_min` to
    /// `range_max`; otherwise it is unknown.
    pub fn write(&self, scan: &mut LaserScan) -> bool {
        let limits = &self.limits;
        let known = |beam: &Beam| beam.obstacle.min(beam.below);
        let start = self.beams.iter().map(known).fold(limits.range_min, f64::min);
        let start = start.max(CELL);
        scan.angle_min = limits.angle_min as f32;
        scan.angle_increment = limits.angle_increment as f32;
        scan.time_increment = 0.0;
        scan.scan_time = 0.0;
        scan.range_min = start as f32;
        scan.range_max = limits.range_max as f32;
        scan.intensities.clear();
        let mut is_known = false;
        for (beam, range) in scan.ranges.resize(self.beams.len()).iter_mut().enumerate() {
            let Beam { obstacle, below } = self.beams[beam];
            let nearest = obstacle.min(self.edge(beam, start, below)).max(start);
            let is_free = nearest >= limits.range_max;
            *range = match self.gap(beam, start, nearest) {
                None if is_free => f32::INFINITY,
                None => nearest as f32,
                Some(_) if is_free => f32::NAN,
                Some(last) if last > start => last as f32,
                Some(_) => f32::NEG_INFINITY,
            };
            is_known |= !range.is_nan();
        }
        scan.state_last_angle();
        is_known
    }

    /// Returns from where on each beam that has floor has some, m; `None` if none has.
    #[must_use]
    pub fn floor_from(&self) -> Option<f64> {
        let first = |beam| self.cells_of(beam).iter().position(|seen| *seen);
        let last = (0..self.beams.len()).filter_map(first).max();
        last.map(|cell| cell as f64 * CELL)
    }

    /// Returns where the floor ends before a place at which it is missing: at the last one that was seen, or there.
    fn edge(&self, beam: usize, start: f64, below: f64) -> f64 {
        if below.is_infinite() {
            return below;
        }
        let seen = self.cells_of(beam).iter().enumerate();
        let seen = seen
            .filter(|(_, seen)| **seen)
            .map(|(cell, _)| cell as f64 * CELL);
        let last = seen.take_while(|range| *range < below).last();
        last.filter(|range| *range >= start).unwrap_or(below)
    }

    /// Returns after which floor so much is unseen that an obstacle may stand there, between two places of the way: `start`
    /// if there is no floor before. `None` if the floor is seen all the way.
    fn gap(&self, beam: usize, start: f64, end: f64) -> Option<f64> {
        let (mut last, mut unseen) = (start, 0);
        let first = (start / CELL) as usize;
        for (cell, seen) in self.cells_of(beam).iter().enumerate().skip(first) {
            let at = cell as f64 * CELL;
            if at >= end {
                break;
            }
            if *seen {
                (last, unseen) = (at.max(start), 0);
                continue;
            }
            unseen += 1;
            if unseen > self.limits.hidden(last) {
                return Some(last);
            }
        }
        None
    }

    fn cells_of(&self, beam: usize) -> &[bool] {
        &self.floor[beam * self.cells..][..self.cells]
    }
}
