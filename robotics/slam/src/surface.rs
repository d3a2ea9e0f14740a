//! The surfaces that several scans show, in one frame: which of their points is nearest to a place, and how likely the
//! end of a beam is there.

use jde_types::Pose2D;

use crate::scan::{Scan, SurfacePoint};

/// The side of a cell, m.
pub(crate) const CELL: f32 = 0.05;
/// How far from a surface a place is near it, in cells.
const MATCH_RADIUS: i32 = 6;
/// The standard deviation of the ends of beams, in cells: that of the laser, of the poses and of the cells.
const DEVIATION: f32 = 2.0;
/// The number of no point.
const NONE: u32 = u32::MAX;

/// The points of scans in the frame of one pose, and a grid over them.
#[derive(Clone, Debug, Default)]
pub struct Surface {
    points: Vec<SurfacePoint>,
    /// The place of the first cell, m.
    origin: (f32, f32),
    width: usize,
    height: usize,
    /// The nearest point of each cell.
    nearest: Vec<u32>,
    /// How likely the end of a beam is in a cell, from 0 to 255; then the maxima of 2 × 2 cells, of 4 × 4, and so on.
    pub(crate) levels: Vec<Vec<u8>>,
}

impl Surface {
    /// Joins the points of scans at poses. It can be searched in windows of 2 to the power of `levels` cells.
    #[must_use]
    pub fn new<'a>(scans: impl IntoIterator<Item = (Pose2D, &'a Scan)>, levels: usize) -> Self {
        let mut points = Vec::new();
        for (pose, scan) in scans {
            let (sin, cos) = libm::sincos(pose.theta);
            let (place, turn) = ((pose.x as f32, pose.y as f32), (sin as f32, cos as f32));
            points.extend(scan.points().iter().map(|point| point.moved(place, turn)));
        }
        if points.is_empty() {
            return Self::default();
        }
        let mut surface = Self::around(&points, levels);
        surface.join(points);
        surface.spread();
        for level in 0..levels {
            let next = surface.maxima(level);
            surface.levels.push(next);
        }
        surface
    }

    /// An empty grid with room around the points.
    fn around(points: &[SurfacePoint], levels: usize) -> Self {
        let mut low = (f32::INFINITY, f32::INFINITY);
        let mut high = (f32::NEG_INFINITY, f32::NEG_INFINITY);
        for point in points {
            low = (low.0.min(point.at.0), low.1.min(point.at.1));
            high = (high.0.max(point.at.0), high.1.max(point.at.1));
        }
        let margin = (MATCH_RADIUS + 1 + (1 << levels)) as f32 * CELL;
        let side = |low: f32, high: f32| ((high - low + 2.0 * margin) / CELL) as usize + 1;
        let (width, height) = (side(low.0, high.0), side(low.1, high.1));
        Self {
            points: Vec::new(),
            origin: (low.0 - margin, low.1 - margin),
            width,
            height,
            nearest: vec![NONE; width * height],
            levels: vec![vec![0; width * height]],
        }
    }

    /// Points in one cell that face the same way become one, their mean.
    fn join(&mut self, points: Vec<SurfacePoint>) {
        let mut counts: Vec<f32> = Vec::new();
        for point in points {
            let Some(cell) = self.cell(point.at) else { continue };
            let known = self.nearest[cell];
            if known == NONE {
                self.nearest[cell] = self.points.len() as u32;
                self.points.push(point);
                counts.push(1.0);
                continue;
            }
            let joined = &mut self.points[known as usize];
            if joined.is_flat() && point.is_flat() && facing(joined.normal, point.normal) > 0.0 {
                let count = &mut counts[known as usize];
                *count += 1.0;
                let mean = |a: f32, b: f32| a + (b - a) / *count;
                joined.at = (mean(joined.at.0, point.at.0), mean(joined.at.1, point.at.1));
                let normal = (
                    mean(joined.normal.0, point.normal.0),
                    mean(joined.normal.1, point.normal.1),
                );
                let length = libm::hypotf(normal.0, normal.1);
                if length > 0.0 {
                    joined.normal = (normal.0 / length, normal.1 / length);
                }
            } else if point.is_flat() && !joined.is_flat() {
                *joined = point;
            }
        }
    }

    /// Makes the cells around each point near it.
    fn spread(&mut self) {
        self.nearest.fill(NONE);
        let mut squares = vec![f32::INFINITY; self.nearest.len()];
        for (number, point) in self.points.iter().enumerate() {
            let (x, y) = self.place(point.at);
            let (column, row) = (x as i32, y as i32);
            for row in row - MATCH_RADIUS..=row + MATCH_RADIUS {
                for column in column - MATCH_RADIUS..=column + MATCH_RADIUS {
                    // The margin has room for them.
                    let cell = row as usize * self.width + column as usize;
                    let (dx, dy) = (column as f32 + 0.5 - x, row as f32 + 0.5 - y);
                    let square = dx * dx + dy * dy;
                    if square < squares[cell] {
                        squares[cell] = square;
                        self.nearest[cell] = number as u32;
                    }
                }
            }
        }
        for (likelihood, square) in self.levels[0].iter_mut().zip(squares) {
            if square.is_finite() {
                *likelihood = (255.0 * libm::expf(-0.5 * square / (DEVIATION * DEVIATION))) as u8;
            }
        }
    }

    /// The maxima of squares whose side is twice that of the level's.
    fn maxima(&self, level: usize) -> Vec<u8> {
        let (of, shift) = (&self.levels[level], 1 << level);
        let mut wide = of.clone();
        for row in 0..self.height {
            let row = row * self.width..(row + 1) * self.width;
            let (to, from) = (&mut wide[row.clone()], &of[row]);
            for (to, from) in to.iter_mut().zip(&from[shift.min(self.width)..]) {
                *to = (*to).max(*from);
            }
        }
        let mut high = wide.clone();
        let skip = (shift * self.width).min(wide.len());
        for (to, from) in high.iter_mut().zip(&wide[skip..]) {
            *to = (*to).max(*from);
        }
        high
    }

    /// Columns and rows with fractions.
    pub(crate) fn place(&self, at: (f32, f32)) -> (f32, f32) {
        ((at.0 - self.origin.0) / CELL, (at.1 - self.origin.1) / CELL)
    }

    fn cell(&self, at: (f32, f32)) -> Option<usize> {
        let (x, y) = self.place(at);
        let is_inside = x >= 0.0 && y >= 0.0 && x < self.width as f32 && y < self.height as f32;
        is_inside.then(|| y as usize * self.width + x as usize)
    }

    /// The point nearest to a place, if there is one within 0.3 m.
    pub(crate) fn nearest(&self, at: (f32, f32)) -> Option<&SurfacePoint> {
        self.points.get(self.nearest[self.cell(at)?] as usize)
    }

    /// The greatest likelihood in the square of this level that begins at a column and row.
    pub(crate) fn most(&self, level: usize, column: i32, row: i32) -> u8 {
        let is_inside = (0..self.width as i32).contains(&column) && (0..self.height as i32).contains(&row);
        if is_inside {
            self.levels[level][row as usize * self.width + column as usize]
        } else {
            0
        }
    }

    /// Returns the points.
    #[must_use]
    pub fn points(&self) -> &[SurfacePoint] {
        &self.points
    }
}

/// The cosine between two normals.
pub(crate) fn facing(a: (f32, f32), b: (f32, f32)) -> f32 {
    a.0 * b.0 + a.1 * b.1
}
