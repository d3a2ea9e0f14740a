//! From a picture to its tags.

use crate::segments::Segments;
use crate::threshold::{Tone, tones};
use crate::{Family, Gray, Point, decode, edges, quad};

/// Finds tags in pictures, and keeps its buffers from one to the next.
#[derive(Debug)]
pub struct Detector {
    /// The families to find.
    pub families: Vec<Family>,
    /// Bits of a tag that may be read wrongly. More find more tags, and more that are none.
    pub hamming: u32,
    /// The columns and rows from one that is searched for quadrilaterals to the next, 1 to 8: 2 needs a quarter of the time,
    /// and misses small tags. Corners and bits come from the whole picture nevertheless.
    pub step: usize,
    thinned: Vec<u8>,
    tones: Vec<Tone>,
    segments: Segments,
}

/// A tag in a picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Detection {
    /// The family.
    pub family: Family,
    /// The number of the tag in its family.
    pub id: u32,
    /// Bits that were read wrongly.
    pub hamming: u32,
    /// How clearly black and white cells differ, from 0 up to about 250: three quarters of the contrast for a sharp
    /// picture. False tags have small margins.
    pub margin: f64,
    /// The corners of its black border: lower left, lower right, upper right, upper left as one who reads the tag
    /// sees it, column and row in px.
    pub corners: [[f64; 2]; 4],
}

impl Default for Detector {
    fn default() -> Self {
        Self::new(vec![Family::Tag36h11])
    }
}

impl Detector {
    /// Creates a detector of these families, which searches whole pictures and lets two bits be wrong.
    #[must_use]
    pub fn new(families: Vec<Family>) -> Self {
        Self {
            families,
            hamming: 2,
            step: 1,
            thinned: Vec::new(),
            tones: Vec::new(),
            segments: Segments::default(),
        }
    }

    /// Returns the tags in a picture, by family and number.
    pub fn detect(&mut self, picture: &Gray<'_>) -> Vec<Detection> {
        /// The shortest side of a quadrilateral, px: fewer pixels show no bits.
        const MIN_SIDE: f64 = 3.0;
        let step = self.step.clamp(1, 8);
        let size = picture.thinned(step, &mut self.thinned);
        let Some(thinned) = Gray::new(size, &self.thinned) else {
            return Vec::new();
        };
        tones(&thinned, &mut self.tones);
        let cells = self.families.iter().map(|family| family.width()).min();
        let least = (cells.unwrap_or_default() as f64 / step as f64).max(MIN_SIDE);
        let codes: Vec<(Family, Vec<u64>)> = self
            .families
            .iter()
            .map(|&family| (family, family.codes().collect()))
            .collect();
        let mut found: Vec<Detection> = Vec::new();
        for mut edge in self.segments.edges(&self.tones, thinned.width) {
            let Some(corners) = quad::fit(&thinned, &mut edge, least) else {
                continue;
            };
            // The pixels of the thinned picture are those in the first column and row of each block.
            let mut corners = corners.map(|corner| corner.map(|part| (part - 0.5) * step as f64 + 0.5));
            let fitted = corners;
            edges::refine(picture, &mut corners, step as f64 + 1.0);
            for (family, codes) in &codes {
                // Beside a small tag there may be stronger edges than its own.
                let tag = [corners, fitted]
                    .iter()
                    .find_map(|corners| self.read(picture, corners, *family, codes));
                if let Some(tag) = tag {
                    keep(&mut found, tag);
                }
            }
        }
        found.sort_by_key(|tag| (tag.family.name(), tag.id));
        found
    }

    fn read(
        &self,
        picture: &Gray<'_>,
        corners: &[Point; 4],
        family: Family,
        codes: &[u64],
    ) -> Option<Detection> {
        let reading = decode::read(picture, corners, family)?;
        let tag = family.nearest(codes, reading.code, self.hamming)?;
        // The first corner that was read is the upper left one after so many quarters of a turn.
        let upper_left = tag.turns;
        Some(Detection {
            family,
            id: tag.id,
            hamming: tag.hamming,
            margin: reading.margin,
            corners: [3, 2, 1, 0].map(|index| corners[(upper_left + index) % 4]),
        })
    }
}

/// Adds a tag, unless a clearer reading of the same tag is there: the inner edge of the border may be read too.
fn keep(found: &mut Vec<Detection>, tag: Detection) {
    let same = found.iter_mut().find(|other| {
        let is_same = (other.family, other.id) == (tag.family, tag.id);
        is_same
            && (contains(&other.corners, middle(&tag.corners))
                || contains(&tag.corners, middle(&other.corners)))
    });
    let rank = |tag: &Detection| (std::cmp::Reverse(tag.hamming), tag.margin);
    match same {
        Some(other) if rank(&tag) > rank(other) => *other = tag,
        Some(_) => {}
        None => found.push(tag),
    }
}

fn middle(corners: &[Point; 4]) -> Point {
    [0, 1].map(|axis| corners.iter().map(|corner| corner[axis]).sum::<f64>() / 4.0)
}

/// Returns whether a point is within a convex quadrilateral whose corners go counter-clockwise in the picture.
fn contains(corners: &[Point; 4], point: Point) -> bool {
    (0..4).all(|index| {
        let ([x0, y0], [x1, y1]) = (corners[index], corners[(index + 1) % 4]);
        (x1 - x0) * (point[1] - y0) - (y1 - y0) * (point[0] - x0) < 0.0
    })
}
