//! AprilTags on walls: upright squares that cameras see. They stop nothing, and no other sensor detects them.

use jde_tags::Family;

/// A tag, with the white margin around its border.
#[derive(Clone, Debug)]
pub(crate) struct Tag {
    /// Its middle, in metres.
    pub(crate) place: [f64; 3],
    /// The direction in which it faces, in radians from the world's x axis.
    pub(crate) facing: f64,
    /// The side of a cell, in metres.
    pub(crate) cell: f64,
    pub(crate) cells: Cells,
}

/// The cells of a tag, as sums: the white area above and to the left of each corner of a cell.
#[derive(Clone, Debug)]
pub(crate) struct Cells {
    /// Cells along a side.
    pub(crate) side: usize,
    sums: Vec<f64>,
}

impl Tag {
    /// Returns a tag whose black border is `size` metres wide; `None` if the family has no tag of that number.
    pub(crate) fn new((family, id): (Family, u32), size: f64, place: [f64; 3], facing: f64) -> Option<Self> {
        let cells = Cells::new(&family.cells(id)?, family.width() + 2);
        let cell = size / family.width() as f64;
        Some(Self {
            place,
            facing,
            cell,
            cells,
        })
    }
}

impl Cells {
    fn new(white: &[bool], side: usize) -> Self {
        let mut sums = vec![0.0; (side + 1) * (side + 1)];
        for (row, cells) in white.chunks(side).enumerate() {
            let mut sum = 0.0;
            for (column, white) in cells.iter().enumerate() {
                sum += f64::from(u8::from(*white));
                let below = (row + 1) * (side + 1) + column + 1;
                sums[below] = sums[below - side - 1] + sum;
            }
        }
        Self { side, sums }
    }

    /// Returns the white part of a rectangle around a place, from 0 to 1. The place and the size of the rectangle are in
    /// cells, to the right and down from the upper left corner. The part beyond the edge counts as the rest.
    pub(crate) fn white(&self, place: [f64; 2], size: [f64; 2]) -> f64 {
        /// The least side of the rectangle, in cells: a smaller one is a point.
        const MIN_SIDE: f64 = 1e-6;
        let spans = [0, 1].map(|axis| {
            let half = size[axis].max(MIN_SIDE) / 2.0;
            [place[axis] - half, place[axis] + half].map(|end| end.clamp(0.0, self.side as f64))
        });
        let [[left, right], [top, bottom]] = spans;
        let area = (right - left) * (bottom - top);
        if area == 0.0 {
            return 1.0;
        }
        let white =
            self.above_left(right, bottom) - self.above_left(left, bottom) - self.above_left(right, top)
                + self.above_left(left, top);
        (white / area).clamp(0.0, 1.0)
    }

    /// Returns the white area above and to the left of a place: exactly linear along both axes in each cell.
    fn above_left(&self, x: f64, y: f64) -> f64 {
        let first = |place: f64| (place as usize).min(self.side - 1);
        let (column, row) = (first(x), first(y));
        let (right, down) = (x - column as f64, y - row as f64);
        let sums = |row: usize| {
            let sums = &self.sums[row * (self.side + 1) + column..][..2];
            sums[0] + right * (sums[1] - sums[0])
        };
        sums(row) + down * (sums(row + 1) - sums(row))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_white_part_of_a_rectangle_is_exact() {
        // White, black / black, white.
        let cells = Cells::new(&[true, false, false, true], 2);
        for (place, size, white) in [
            ([0.5, 0.5], [0.0, 0.0], 1.0),
            ([1.5, 0.5], [0.5, 0.5], 0.0),
            ([1.0, 0.5], [1.0, 1.0], 0.5),
            ([1.0, 1.0], [2.0, 2.0], 0.5),
            ([0.75, 0.5], [1.0, 0.2], 0.75),
            ([0.0, 0.5], [1.0, 1.0], 1.0),
            ([5.0, 5.0], [1.0, 1.0], 1.0),
        ] {
            let found = cells.white(place, size);
            assert!(
                (found - white).abs() < 1e-9,
                "{place:?} {size:?}: {found} is not {white}"
            );
        }
    }
}
