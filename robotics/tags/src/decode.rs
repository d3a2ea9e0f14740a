//! Reads the bits of a quadrilateral.

use crate::homography::Homography;
use crate::{Family, Gray, Point};

/// How much of the difference to its neighbours is added to a cell before it is read: against blur.
const SHARPENING: f64 = 0.25;

/// The bits of a quadrilateral.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct CellBits {
    /// Row by row from the first corner to the second, the first the most significant.
    pub(crate) code: u64,
    /// How far the cells are from the threshold between black and white: the lesser of the means of both kinds.
    pub(crate) margin: f64,
}

/// Reads a quadrilateral as a tag of a family, in the order of its corners; `None` if it reaches out of the picture
/// or its border is not black on white.
pub(crate) fn read(picture: &Gray<'_>, corners: &[Point; 4], family: Family) -> Option<CellBits> {
    let homography = Homography::to(corners);
    let width = family.width();
    let sample = |cell: [f64; 2]| {
        let place = cell.map(|part| part / width as f64);
        Some((place, picture.between(homography.project(place))?))
    };
    let (mut white, mut black) = (Plane::default(), Plane::default());
    for index in 0..width {
        let (along, far) = (index as f64 + 0.5, width as f64);
        for (plane, depth) in [(&mut white, -0.5), (&mut black, 0.5)] {
            for cell in [
                [depth, along],
                [far - depth, along],
                [along, depth],
                [along, far - depth],
            ] {
                // The white margin may be cut off.
                let place = cell.map(|part| part / width as f64);
                if let Some(value) = picture.nearest(homography.project(place)) {
                    plane.add(place, value);
                }
            }
        }
    }
    let (white, black) = (white.fit()?, black.fit()?);
    if white.at([0.5; 2]) <= black.at([0.5; 2]) {
        return None;
    }
    let side = family.side();
    let mut cells = Vec::with_capacity(side * side);
    for index in 0..side * side {
        let cell = [index % side, index / side].map(|part| part as f64 + 1.5);
        let (place, value) = sample(cell)?;
        cells.push(value - (white.at(place) + black.at(place)) / 2.0);
    }
    Some(bits(&sharpened(&cells, side)))
}

/// Returns each cell with the sum of its differences to its four neighbours added; beyond the cells is nothing.
fn sharpened(cells: &[f64], side: usize) -> Vec<f64> {
    let at = |row: usize, column: usize| {
        if row < side && column < side {
            cells[row * side + column]
        } else {
            0.0
        }
    };
    let sharp = |index: usize| {
        let (row, column) = (index / side, index % side);
        let around = at(row.wrapping_sub(1), column)
            + at(row + 1, column)
            + at(row, column.wrapping_sub(1))
            + at(row, column + 1);
        cells[index] + SHARPENING * (4.0 * cells[index] - around)
    };
    (0..cells.len()).map(sharp).collect()
}

fn bits(cells: &[f64]) -> CellBits {
    let mut code = 0;
    // Of black and of white cells: the sum of their distances from the threshold, and their number.
    let mut kinds = [(0.0, 1.0); 2];
    for &cell in cells {
        let is_white = cell > 0.0;
        code = code << 1 | u64::from(is_white);
        let (sum, count) = &mut kinds[usize::from(is_white)];
        *sum += cell.abs();
        *count += 1.0;
    }
    let [black, white] = kinds.map(|(sum, count)| sum / count);
    CellBits {
        code,
        margin: black.min(white),
    }
}

/// The brightness of black or of white over a tag, which the light makes uneven: `a + b·u + c·v`.
#[derive(Clone, Copy, Debug, Default)]
struct Plane {
    /// The sums of 1, u, v, uu, uv, vv, and of the values times 1, u and v.
    sums: [f64; 9],
    factors: [f64; 3],
}

impl Plane {
    fn add(&mut self, [u, v]: Point, value: f64) {
        let terms = [1.0, u, v, u * u, u * v, v * v, value, u * value, v * value];
        self.sums
            .iter_mut()
            .zip(terms)
            .for_each(|(sum, term)| *sum += term);
    }

    /// Returns the plane with the least squared differences; `None` for too few values.
    fn fit(mut self) -> Option<Self> {
        let [n, u, v, uu, uv, vv, a, b, c] = self.sums;
        let determinant = |m: [[f64; 3]; 3]| {
            m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1])
                - m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0])
                + m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0])
        };
        let whole = determinant([[n, u, v], [u, uu, uv], [v, uv, vv]]);
        if whole.abs() < 1e-9 {
            return None;
        }
        self.factors = [
            determinant([[a, u, v], [b, uu, uv], [c, uv, vv]]) / whole,
            determinant([[n, a, v], [u, b, uv], [v, c, vv]]) / whole,
            determinant([[n, u, a], [u, uu, b], [v, uv, c]]) / whole,
        ];
        Some(self)
    }

    fn at(&self, [u, v]: Point) -> f64 {
        self.factors[0] + self.factors[1] * u + self.factors[2] * v
    }
}
