//! The segments of a scan that may be legs.

use jde_types::{LaserScan, Unmeasured};

use crate::features::{Features, distance, mean};
use crate::model;
use crate::segments::{Hit, Segments};

/// The most legs in one scan. Of more, the most confident ones count.
pub const MOST_LEGS: usize = 64;
/// From its surface to the middle of a leg, m.
const DEEP: f64 = 0.05;

/// What is a leg.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DetectorSettings {
    /// A segment ends where the next hit is farther than this, m.
    pub jump: f64,
    /// The fewest hits of a leg.
    pub hits: usize,
    /// The greatest width of a leg, or of two that look like one, m.
    pub width: f64,
    /// How far from the laser legs are searched, m.
    pub range: f64,
    /// The least confidence of what may be the leg of a person that is known.
    pub confidence: f64,
}

impl Default for DetectorSettings {
    fn default() -> Self {
        Self {
            jump: 0.13,
            hits: 2,
            width: 0.7,
            range: 10.0,
            confidence: 0.1,
        }
    }
}

impl DetectorSettings {
    /// Returns whether these neighbouring hits are enough, not too wide and near enough to be a leg.
    #[must_use]
    pub fn admits(&self, hits: &[Hit]) -> bool {
        let (x, y) = mean(hits);
        hits.len() >= self.hits.max(1) && width(hits) <= self.width && libm::hypot(x, y) <= self.range
    }
}

/// Returns the distance between the ends.
fn width(hits: &[Hit]) -> f64 {
    distance(&hits[0], &hits[hits.len() - 1])
}

/// A segment that may be a leg, or two legs close together.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Leg {
    /// Its middle in the frame of the laser, m.
    pub x: f64,
    /// The same to the left, m.
    pub y: f64,
    /// The distance between its ends, m.
    pub width: f64,
    /// The probability that it is one, from 0 to 1.
    pub confidence: f64,
}

/// Finds legs; it keeps its memory from one scan to the next.
#[derive(Clone, Debug, Default)]
pub struct Detector {
    segments: Segments,
    legs: Vec<Leg>,
    /// The middles of all other segments' hits.
    obstacles: Vec<(f64, f64)>,
}

impl Detector {
    /// Finds the legs in a scan.
    ///
    /// # Errors
    /// As [`LaserScan::measured`]. Then there are none.
    pub fn detect(&mut self, settings: &DetectorSettings, scan: &LaserScan) -> Result<(), Unmeasured> {
        self.legs.clear();
        self.obstacles.clear();
        self.segments.update(scan, settings.jump)?;
        let hits = self.segments.hits();
        for segment in self.segments.segments() {
            let own = &hits[segment.hits.clone()];
            if settings.admits(own) {
                let confidence = model::leg_confidence(&Features::new(hits, segment));
                if confidence >= settings.confidence {
                    let (x, y) = mean(own);
                    let behind = 1.0 + DEEP / libm::hypot(x, y);
                    self.legs.push(Leg {
                        x: x * behind,
                        y: y * behind,
                        width: width(own),
                        confidence,
                    });
                    continue;
                }
            }
            self.obstacles.extend(own.iter().map(|hit| (hit.x, hit.y)));
        }
        if self.legs.len() > MOST_LEGS {
            self.legs
                .sort_unstable_by(|a, b| b.confidence.total_cmp(&a.confidence));
            self.legs.truncate(MOST_LEGS);
        }
        Ok(())
    }

    /// Returns the legs of the last scan.
    #[must_use]
    pub fn legs(&self) -> &[Leg] {
        &self.legs
    }

    /// Returns all hits of the last scan that are no legs, in the frame of the laser, m.
    #[must_use]
    pub fn obstacles(&self) -> &[(f64, f64)] {
        &self.obstacles
    }
}
