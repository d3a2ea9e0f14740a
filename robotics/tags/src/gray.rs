//! A picture of brightness.

use crate::Point;

/// A picture of brightness, one byte a pixel. It copies nothing.
#[derive(Clone, Copy, Debug)]
pub struct Gray<'a> {
    pub(crate) width: usize,
    pub(crate) height: usize,
    pixels: &'a [u8],
}

impl<'a> Gray<'a> {
    /// Returns the picture of some columns and rows; `None` if the pixels are not as many.
    #[must_use]
    pub fn new([width, height]: [usize; 2], pixels: &'a [u8]) -> Option<Self> {
        let is_complete = width.checked_mul(height) == Some(pixels.len());
        is_complete.then_some(Self {
            width,
            height,
            pixels,
        })
    }

    /// Returns the brightness of a pixel.
    pub(crate) fn at(&self, column: usize, row: usize) -> u8 {
        self.pixels[row * self.width + column]
    }

    pub(crate) fn row(&self, row: usize) -> &[u8] {
        &self.pixels[row * self.width..(row + 1) * self.width]
    }

    /// Returns the brightness at a place, between the middles of the pixels around it; `None` at the edge of the
    /// picture and outside.
    pub(crate) fn between(&self, [column, row]: Point) -> Option<f64> {
        let (x, y) = (column - 0.5, row - 0.5);
        let inside = |place: f64, count: usize| place >= 0.0 && place < count.saturating_sub(1) as f64;
        if !inside(x, self.width) || !inside(y, self.height) {
            return None;
        }
        let (left, top) = (x as usize, y as usize);
        let (right, down) = (x - left as f64, y - top as f64);
        let mean = |row: usize| {
            let pair = [0, 1].map(|step| f64::from(self.at(left + step, row)));
            pair[0] + right * (pair[1] - pair[0])
        };
        let (upper, lower) = (mean(top), mean(top + 1));
        Some(upper + down * (lower - upper))
    }

    /// Returns the brightness of the pixel at a place; `None` outside the picture.
    pub(crate) fn nearest(&self, [column, row]: Point) -> Option<f64> {
        let inside = |place: f64, count: usize| place >= 0.0 && place < count as f64;
        (inside(column, self.width) && inside(row, self.height))
            .then(|| f64::from(self.at(column as usize, row as usize)))
    }

    /// Fills `pixels` with every `step`-th pixel of every `step`-th row, and returns columns and rows.
    pub(crate) fn thinned(&self, step: usize, pixels: &mut Vec<u8>) -> [usize; 2] {
        pixels.clear();
        for row in (0..self.height).step_by(step) {
            pixels.extend(self.row(row).iter().step_by(step));
        }
        [self.width.div_ceil(step), self.height.div_ceil(step)]
    }
}
