//! The exact Euclidean distance field, in linear time (Felzenszwalb and Huttenlocher, "Distance transforms of
//! sampled functions", 2012). It counts in cells, and does not know where they are.

/// The square of the distance where there is no source.
pub const NO_SOURCE: u32 = u32::MAX;

/// Computes distances, and keeps its memory from one grid to the next.
#[derive(Clone, Debug, Default)]
pub struct Distances {
    squares: Vec<u32>,
    /// One row: the distance to the nearest source in each column so far, and the result of a row.
    row: Vec<u32>,
    envelope: Envelope,
}

/// Returns, for each cell of a grid with `width` columns, the square of the distance from its centre to that
/// of the nearest source, in cells. All are [`NO_SOURCE`] without any source.
///
/// The result is exact up to 2¹⁵ columns and rows: squares are integers, and the comparisons of two parabolas
/// divide numbers below 2³² by numbers below 2¹⁶, whose rounding passes no integer.
///
/// # Panics
/// If the number of cells is not a multiple of `width`.
#[must_use]
pub fn squared_distances(width: usize, sources: &[bool]) -> Vec<u32> {
    let mut distances = Distances::default();
    distances.squared(width, sources);
    distances.squares
}

impl Distances {
    /// Returns what [`squared_distances`] returns. Allocates only for a grid larger than those before.
    ///
    /// # Panics
    /// If the number of cells is not a multiple of `width`.
    pub fn squared(&mut self, width: usize, sources: &[bool]) -> &[u32] {
        self.squared_within(width, sources, NO_SOURCE - 1)
    }

    /// As [`Distances::squared`] for squares up to `most`. A cell farther from each source has a greater number,
    /// which is not its distance. It takes less time where most cells are farther.
    ///
    /// # Panics
    /// If the number of cells is not a multiple of `width`.
    pub fn squared_within(&mut self, width: usize, sources: &[bool], most: u32) -> &[u32] {
        let height = sources.len().checked_div(width).unwrap_or(0);
        assert_eq!(height * width, sources.len(), "whole rows");
        self.squares.clear();
        let source = |&source: &bool| if source { 0 } else { NO_SOURCE };
        self.squares.extend(sources.iter().map(source));
        self.row.clear();
        self.row.resize(width, NO_SOURCE);
        along_columns(&mut self.row, &mut self.squares);
        for row in self.squares.chunks_exact_mut(width.max(1)) {
            self.envelope.transform(row, most, &mut self.row);
            row.copy_from_slice(&self.row);
        }
        &self.squares
    }
}

/// Replaces each cell by the square of the distance to the nearest source in its column. Sources are 0 and
/// all others [`NO_SOURCE`], and so is `away`, a row. So two passes of counting suffice, and both run along rows
/// of the memory.
fn along_columns(away: &mut [u32], squares: &mut [u32]) {
    let width = away.len();
    let height = squares.len() / width.max(1);
    let mut pass = |squares: &mut [u32], y: usize| {
        for (away, square) in away.iter_mut().zip(&mut squares[y * width..(y + 1) * width]) {
            *away = if *square == 0 { 0 } else { away.saturating_add(1) };
            *square = (*square).min(away.checked_mul(*away).unwrap_or(NO_SOURCE));
        }
    };
    for y in 0..height {
        pass(squares, y);
    }
    // The distances of the last row hold for the way back as well: the nearest source so far lies above it.
    for y in (0..height).rev() {
        pass(squares, y);
    }
}

/// The lower envelope of parabolas, one for each cell of a line.
#[derive(Clone, Debug, Default)]
struct Envelope {
    /// The cells whose parabolas belong to it, from left to right, and where each begins to be the lowest.
    parts: Vec<(usize, f64)>,
}

impl Envelope {
    /// Writes for each cell the least of all parabolas `squares[q] + (x - q)²` that are `most` or less at `q`.
    fn transform(&mut self, squares: &[u32], most: u32, line: &mut [u32]) {
        self.parts.clear();
        for (q, &square) in squares.iter().enumerate() {
            if square > most {
                continue;
            }
            let height = |q: usize| f64::from(squares[q]) + (q * q) as f64;
            let mut start = f64::NEG_INFINITY;
            while let Some(&(v, begin)) = self.parts.last() {
                start = (height(q) - height(v)) / (2.0 * (q - v) as f64);
                if start > begin {
                    break;
                }
                self.parts.pop();
                start = f64::NEG_INFINITY;
            }
            self.parts.push((q, start));
        }
        if self.parts.is_empty() {
            line.fill(NO_SOURCE);
            return;
        }
        let mut first = 0;
        for (part, &(q, _)) in self.parts.iter().enumerate() {
            // A part ends with the last cell that is not beyond the beginning of the next one.
            let end = match self.parts.get(part + 1) {
                Some(&(_, begin)) if begin < 0.0 => 0,
                Some(&(_, begin)) => line.len().min(begin as usize + 1),
                None => line.len(),
            };
            for (x, value) in (first..end).zip(&mut line[first..end.max(first)]) {
                let away = x.abs_diff(q) as u32;
                *value = squares[q] + away * away;
            }
            first = first.max(end);
        }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    /// The definition: the least over all sources.
    fn by_search(width: usize, sources: &[bool]) -> Vec<u32> {
        let place = |index: usize| ((index % width) as i64, (index / width) as i64);
        let square = |a: usize, b: usize| {
            let ((ax, ay), (bx, by)) = (place(a), place(b));
            ((ax - bx).pow(2) + (ay - by).pow(2)) as u32
        };
        (0..sources.len())
            .map(|cell| {
                let to = (0..sources.len()).filter(|&source| sources[source]);
                to.map(|source| square(cell, source)).min().unwrap_or(NO_SOURCE)
            })
            .collect()
    }

    #[test]
    fn a_grid_of_one_cell_and_an_empty_one_have_a_field() {
        assert_eq!(squared_distances(1, &[true]), [0]);
        assert_eq!(squared_distances(1, &[false]), [NO_SOURCE]);
        assert!(squared_distances(0, &[]).is_empty());
    }

    proptest! {
        #[test]
        fn it_is_the_least_distance_to_any_source(
            width in 1usize..24,
            sources in prop::collection::vec(prop::bool::weighted(0.05), 1..500),
            most in 0u32..60,
        ) {
            let rows = sources.len() / width;
            let sources = &sources[..rows * width];
            let expected = by_search(width, sources);
            prop_assert_eq!(&squared_distances(width, sources), &expected);
            let mut distances = Distances::default();
            let within = distances.squared_within(width, sources, most);
            for (within, expected) in within.iter().zip(&expected) {
                prop_assert_eq!((*within).min(most + 1), (*expected).min(most + 1));
            }
        }
    }
}
