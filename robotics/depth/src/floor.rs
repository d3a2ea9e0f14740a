//! The scan: in each direction the nearest obstacle or edge, or whether the floor is seen all the way.

use jde_schema::types::LaserScan;

/// Part of the way of which it is known whether its floor was seen, m.
const CELL: f64 = 0.05;
/// The longest part of the way without a measured place on the floor that still counts as seen, m: a few rows of a picture.
const GAP: f64 = 0.3;
/// The most beams that a `LaserScan` has room for.
const MAX_BEAMS: f64 = 1088.0;

/// What counts. The names are those of ROS's `pointcloud_to_laserscan`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits {
    /// Least height of an obstacle, m. What is lower is floor.
    pub min_height: f64,
    /// Greatest height of an obstacle, m: the robot passes below what is higher.
    pub max_height: f64,
    /// How far below the floor something must be to be a cliff, m.
    pub max_drop: f64,
    /// From where on the floor must be seen, m.
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
    /// The cells of the way from `range_min` to `range_max` whose floor was seen, beam by beam.
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
}

impl FloorScan {
    /// Nothing was seen.
    ///
    /// # Errors
    /// The limits contradict each other.
    pub fn new(limits: Limits) -> Result<Self, LimitsError> {
        let beams = limits.beams()?;
        let cells = ((limits.range_max - limits.range_min) / CELL).ceil() as usize;
        Ok(Self {
            limits,
            beams: vec![Beam::NOTHING; beams],
            floor: vec![false; beams * cells],
            cells,
        })
    }

    /// Adds a point that a sensor at a height above the origin measured. One that is not finite says nothing.
    pub fn add(&mut self, height: f64, [x, y, z]: [f64; 3]) {
        let Limits {
            min_height,
            max_height,
            max_drop,
            range_min,
            range_max,
            angle_min,
            angle_increment,
            ..
        } = self.limits;
        let (range, place) = (x.hypot(y), ((y.atan2(x) - angle_min) / angle_increment).round());
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
        } else if range < range_max {
            let cell = ((range - range_min) / CELL).max(0.0) as usize;
            self.floor[beam * self.cells + cell.min(self.cells - 1)] = true;
        }
    }

    /// Writes the scan. Its origin is that of the points. Returns whether anything is known.
    ///
    /// A beam ends at the nearest obstacle, or at the last floor before a cliff. It is free if the floor is seen from
    /// `range_min` to `range_max`; otherwise it is unknown.
    pub fn write(&self, scan: &mut LaserScan) -> bool {
        let limits = &self.limits;
        scan.angle_min = limits.angle_min as f32;
        scan.angle_increment = limits.angle_increment as f32;
        scan.time_increment = 0.0;
        scan.scan_time = 0.0;
        scan.range_min = limits.range_min.min(CELL) as f32;
        scan.range_max = limits.range_max as f32;
        scan.intensities.clear();
        let least = f64::from(scan.range_min);
        let mut is_known = false;
        for (beam, range) in scan.ranges.resize(self.beams.len()).iter_mut().enumerate() {
            let Beam { obstacle, below } = self.beams[beam];
            let nearest = obstacle.min(self.edge(beam, below)).max(least);
            *range = if nearest < limits.range_max {
                nearest as f32
            } else if self.is_floor(beam) {
                f32::INFINITY
            } else {
                f32::NAN
            };
            is_known |= !range.is_nan();
        }
        scan.state_last_angle();
        is_known
    }

    /// Returns where the floor ends before a place at which it is missing: at the last one that was seen, or there.
    fn edge(&self, beam: usize, below: f64) -> f64 {
        let start = self.limits.range_min;
        let cells = self.cells_of(beam).iter().enumerate();
        let seen = cells
            .filter(|(_, seen)| **seen)
            .map(|(cell, _)| start + cell as f64 * CELL);
        let last = seen.take_while(|range| *range < below).last();
        last.filter(|_| below.is_finite()).unwrap_or(below)
    }

    /// Whether the floor is seen all the way.
    fn is_floor(&self, beam: usize) -> bool {
        let most = (GAP / CELL) as usize;
        self.cells_of(beam)
            .chunk_by(|a, b| a == b)
            .all(|run| run[0] || run.len() <= most)
    }

    fn cells_of(&self, beam: usize) -> &[bool] {
        &self.floor[beam * self.cells..][..self.cells]
    }
}
