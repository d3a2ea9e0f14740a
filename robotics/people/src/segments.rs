//! A scan cut into segments where neighbouring beams end far apart.

use core::f64::consts::TAU;
use core::ops::Range;

use jde_types::{Echo, LaserScan, Unmeasured};

/// What a jump beside a segment counts at most, m: what is farther behind tells no more.
const MOST_JUMP: f64 = 1.0;

/// The least angle between a wall and a beam at which the wall is one segment, rad, and how much farther than else its
/// hits may be at most.
const GRAZING: f64 = 12.0 * TAU / 360.0;
const MOST_SPREAD: f64 = 4.0;

/// Where a beam ends, in the frame of the laser.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Hit {
    /// Ahead, m.
    pub x: f64,
    /// To the left, m.
    pub y: f64,
    /// The length of the beam, m.
    pub range: f64,
    /// The number of the beam.
    pub beam: usize,
}

/// Neighbouring hits of which each is near the one before.
#[derive(Clone, Debug, PartialEq)]
pub struct Segment {
    /// Its hits, among those of the scan.
    pub hits: Range<usize>,
    /// How much farther the beam before it ends, and the beam after it, m; from -1 to 1, 1 where nothing is hit, and 0
    /// at the edge of the scan. Beams that measure nothing are left out.
    pub jumps: [f64; 2],
}

/// The segments of one scan; it keeps its memory from one scan to the next.
#[derive(Clone, Debug, Default)]
pub struct Segments {
    hits: Vec<Hit>,
    segments: Vec<Segment>,
}

impl Segments {
    /// Replaces the segments by those of `scan`. A segment ends where the next hit is farther away than `jump` m,
    /// and than on a wall at an angle of 12 degrees to neighbouring beams (after Borges and Aldon, 2004).
    ///
    /// What is too close to measure is no hit. In a scan all around, the last beam is the neighbour of the first.
    ///
    /// # Errors
    /// As [`LaserScan::measured`]. Then there are none.
    pub fn update(&mut self, scan: &LaserScan, jump: f64) -> Result<(), Unmeasured> {
        self.hits.clear();
        self.segments.clear();
        scan.measured()?;
        for (beam, echo) in scan.echoes() {
            if let Echo::Hit(range) = echo {
                let (sin, cos) = libm::sincos(scan.angle(beam));
                let range = f64::from(range);
                self.hits.push(Hit {
                    x: range * cos,
                    y: range * sin,
                    range,
                    beam,
                });
            }
        }
        let increment = f64::from(scan.angle_increment).abs();
        // Where a wall that is seen at a small angle has its next hit.
        let spread = libm::sin(increment) / libm::sin((GRAZING - increment).max(increment));
        let is_cut = |a: &Hit, b: &Hit| {
            let is_next = a.beam + 1 == b.beam || a.beam > b.beam;
            let spacing = if is_next {
                spread * a.range.min(b.range)
            } else {
                0.0
            };
            libm::hypot(a.x - b.x, a.y - b.y) > jump.max(spacing.min(MOST_SPREAD * jump))
        };
        let beams = scan.ranges.len();
        let is_around = increment * beams as f64 > TAU - increment / 2.0;
        if is_around && let Some(cut) = self.hits.windows(2).position(|pair| is_cut(&pair[0], &pair[1])) {
            self.hits.rotate_left(cut + 1);
        }
        let mut first = 0;
        for end in 1..=self.hits.len() {
            let is_end = self
                .hits
                .get(end)
                .is_none_or(|next| is_cut(&self.hits[end - 1], next));
            if is_end {
                let jumps = [(first, beams - 1), (end - 1, 1)].map(|(hit, step)| {
                    let Hit { beam, range, .. } = self.hits[hit];
                    let beside = neighbour(scan, beam, step, is_around);
                    beside.map_or(0.0, |beside| {
                        (f64::from(beside) - range).clamp(-MOST_JUMP, MOST_JUMP)
                    })
                });
                self.segments.push(Segment {
                    hits: first..end,
                    jumps,
                });
                first = end;
            }
        }
        Ok(())
    }

    /// Returns the segments, by the angle of their first hits; in a scan all around from some angle on.
    #[must_use]
    pub fn segments(&self) -> &[Segment] {
        &self.segments
    }

    /// Returns all hits, segment by segment.
    #[must_use]
    pub fn hits(&self) -> &[Hit] {
        &self.hits
    }
}

/// Returns the next range that is measured, `step` beams on from each to the next, unless the edge of the scan comes
/// first.
fn neighbour(scan: &LaserScan, beam: usize, step: usize, is_around: bool) -> Option<f32> {
    let ranges = scan.ranges.as_slice();
    let edge = if step == 1 { ranges.len() - 1 } else { 0 };
    let mut beam = beam;
    for _ in 0..ranges.len() {
        if beam == edge && !is_around {
            return None;
        }
        beam = (beam + step) % ranges.len();
        if Echo::of(ranges[beam], scan.range_min, scan.range_max) != Echo::Nothing {
            return Some(ranges[beam]);
        }
    }
    None
}
