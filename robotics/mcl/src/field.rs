//! The field of a map: how far the nearest obstacle is from each cell, rays through it, and which cells are free.
//!
//! Places are columns and rows with fractions, and distances are in cells, as [`Geometry::to_grid`] counts them.

use jde_grid::{Geometry, Occupancy, OccupancyGrid, squared_distances};

/// The parts of a cell in which distances are counted.
const PARTS: f32 = 8.0;
/// No distance: that of all that is farther, and outside the map.
const MAX_DISTANCE: u8 = u8::MAX;
/// The square from which on a distance is the greatest, in cells.
const FAR_SQUARE: u32 = 32 * 32;
/// What the distance between the centres of two cells can exceed that of their points by, in cells.
const DIAGONAL: f32 = core::f32::consts::SQRT_2;

/// Cells of a row that are free.
#[derive(Clone, Copy, Debug)]
struct Span {
    /// The index of the first.
    first: u32,
    /// How many cells of the spans before are free.
    before: u32,
}

/// A map, prepared for localization. It takes a byte for each cell, and eight for each run of free cells.
#[derive(Clone, Debug)]
pub struct LikelihoodField {
    geometry: Geometry,
    near: Vec<u8>,
    spans: Vec<Span>,
    free: u32,
}

impl LikelihoodField {
    /// Prepares a map. Takes time by the number of cells.
    #[must_use]
    pub fn new(map: &OccupancyGrid) -> Self {
        let geometry = *map.geometry();
        let width = geometry.width() as usize;
        let sources: Vec<bool> = map
            .cells()
            .iter()
            .map(|&cell| cell == Occupancy::Occupied)
            .collect();
        let parts: Vec<u8> = (0..FAR_SQUARE)
            .map(|square| (PARTS * libm::sqrtf(square as f32)) as u8)
            .collect();
        let squares = squared_distances(width, &sources);
        let part = |square: &u32| parts.get(*square as usize).copied().unwrap_or(MAX_DISTANCE);
        let near = squares.iter().map(part).collect();
        let (mut spans, mut free) = (Vec::new(), 0);
        let mut was_free = false;
        for (index, &cell) in map.cells().iter().enumerate() {
            let is_free = cell == Occupancy::Free;
            if is_free && !was_free {
                spans.push(Span {
                    first: index as u32,
                    before: free,
                });
            }
            free += u32::from(is_free);
            was_free = is_free;
        }
        Self {
            geometry,
            near,
            spans,
            free,
        }
    }

    /// Returns size, resolution and origin of the map.
    #[must_use]
    pub const fn geometry(&self) -> &Geometry {
        &self.geometry
    }

    /// Returns how many cells are free.
    #[must_use]
    pub const fn free_cells(&self) -> u32 {
        self.free
    }

    /// Returns the middles of an even selection of occupied cells, at most `most`, m.
    pub fn obstacles(&self, most: usize) -> impl Iterator<Item = (f64, f64)> + '_ {
        let occupied = || self.near.iter().enumerate().filter(|(_, parts)| **parts == 0);
        let step = occupied().count().div_ceil(most.max(1)).max(1);
        let middle = |(index, _)| self.geometry.center(self.geometry.cell(index));
        occupied().step_by(step).map(middle)
    }

    /// The free cell with this number, by its lower left corner.
    pub(crate) fn free_cell(&self, number: u32) -> (f32, f32) {
        let span = self.spans.partition_point(|span| span.before <= number);
        let index = span.checked_sub(1).map_or(0, |span| {
            let Span { first, before } = self.spans[span];
            first + (number - before)
        });
        let cell = self.geometry.cell(index as usize);
        (cell.x as f32, cell.y as f32)
    }

    /// Whether the cell at this place is in the map and free.
    pub(crate) fn is_free(&self, x: f32, y: f32) -> bool {
        let Some(index) = self.index(x, y) else {
            return false;
        };
        let next = self.spans.partition_point(|span| span.first as usize <= index);
        let Some(span) = next.checked_sub(1).map(|span| self.spans[span]) else {
            return false;
        };
        let end = self.spans.get(next).map_or(self.free, |span| span.before);
        index - (span.first as usize) < (end - span.before) as usize
    }

    /// The distance at a place, in parts of a cell.
    #[inline]
    pub(crate) fn parts(&self, x: f32, y: f32) -> u8 {
        self.index(x, y).map_or(MAX_DISTANCE, |index| self.near[index])
    }

    /// The distances of all parts, in cells; that of the last is infinite.
    pub(crate) fn distances() -> impl Iterator<Item = f32> {
        (0..=MAX_DISTANCE).map(in_cells)
    }

    /// The distance at a place; infinite if it is great.
    pub(crate) fn distance(&self, x: f32, y: f32) -> f32 {
        in_cells(self.parts(x, y))
    }

    /// How far a ray in the direction (`cos`, `sin`) goes until it meets an obstacle or leaves the map; at most as
    /// far as `most`. It goes on by the distance to the nearest obstacle each time, so that it skips none of the size
    /// of a cell; it may cut a corner by half a cell.
    pub(crate) fn cast(&self, (x, y): (f32, f32), (cos, sin): (f32, f32), most: f32) -> f32 {
        let mut way = 0.0;
        while way < most {
            let Some(index) = self.index(x + way * cos, y + way * sin) else {
                return most;
            };
            match self.near[index] {
                0 => return way,
                parts => way += (f32::from(parts) / PARTS - DIAGONAL).max(0.5),
            }
        }
        most
    }

    #[inline]
    fn index(&self, x: f32, y: f32) -> Option<usize> {
        let (width, height) = (self.geometry.width(), self.geometry.height());
        // Not for NaN either.
        let is_inside = x >= 0.0 && y >= 0.0 && x < width as f32 && y < height as f32;
        is_inside.then(|| y as usize * width as usize + x as usize)
    }
}

fn in_cells(parts: u8) -> f32 {
    if parts == MAX_DISTANCE {
        f32::INFINITY
    } else {
        f32::from(parts) / PARTS
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use jde_grid::Cell;
    use proptest::prelude::*;

    use super::*;

    /// A map of these rows, the lowest last: `#` occupied, `.` free, others unknown.
    pub(crate) fn map(rows: &[&str]) -> OccupancyGrid {
        let geometry = Geometry::new(rows[0].len() as u32, rows.len() as u32, 1.0, (0.0, 0.0, 0.0));
        let mut map = OccupancyGrid::filled(geometry.expect("valid"), Occupancy::Unknown);
        for (y, row) in rows.iter().rev().enumerate() {
            for (x, cell) in row.bytes().enumerate() {
                let state = match cell {
                    b'#' => Occupancy::Occupied,
                    b'.' => Occupancy::Free,
                    _ => Occupancy::Unknown,
                };
                map.set(Cell::new(x as u32, y as u32), state);
            }
        }
        map
    }

    #[test]
    fn distances_are_to_the_nearest_obstacle_and_infinite_outside() {
        let field = LikelihoodField::new(&map(&["#...", "... "]));
        for (x, y, distance) in [
            (0.5, 1.5, 0.0),
            (2.5, 1.5, 2.0),
            (1.9, 0.1, 1.375),
            (-0.1, 0.5, f32::INFINITY),
            (4.0, 0.5, f32::INFINITY),
            (f32::NAN, 0.5, f32::INFINITY),
        ] {
            assert_eq!(field.distance(x, y), distance, "{x}, {y}");
        }
        let empty = LikelihoodField::new(&map(&["."]));
        assert_eq!(empty.distance(0.5, 0.5), f32::INFINITY, "no obstacle at all");
    }

    #[test]
    fn free_cells_are_numbered_and_found_again() {
        let rows = ["#..#..", "......", " .#...", "#    #", "....#."];
        let field = LikelihoodField::new(&map(&rows));
        assert_eq!(field.free_cells(), 19);
        let cells: Vec<_> = (0..19).map(|number| field.free_cell(number)).collect();
        for (y, row) in rows.iter().rev().enumerate() {
            for (x, cell) in row.bytes().enumerate() {
                let (x, y, is_free) = (x as f32, y as f32, cell == b'.');
                assert_eq!(field.is_free(x + 0.5, y + 0.5), is_free, "{x}, {y}");
                assert_eq!(cells.contains(&(x, y)), is_free, "{x}, {y}");
            }
        }
        assert!(!field.is_free(-0.5, 0.5) && !field.is_free(f32::NAN, 0.5));
        assert!(!LikelihoodField::new(&map(&["#"])).is_free(0.5, 0.5));
    }

    #[test]
    fn a_ray_ends_at_the_first_obstacle_or_where_the_map_ends() {
        let field = LikelihoodField::new(&map(&["......#...", ".....#...."]));
        let ahead = (1.0, 0.0);
        assert!((field.cast((0.5, 1.5), ahead, 20.0) - 5.5).abs() <= 0.5);
        assert!((field.cast((0.5, 0.5), ahead, 20.0) - 4.5).abs() <= 0.5);
        assert_eq!(field.cast((0.5, 0.5), ahead, 3.0), 3.0, "no farther than asked");
        assert_eq!(field.cast((0.5, 0.5), (-1.0, 0.0), 20.0), 20.0);
        assert_eq!(field.cast((-3.0, 0.5), ahead, 20.0), 20.0, "from outside");
        assert_eq!(field.cast((0.5, 0.5), (f32::NAN, 0.0), 20.0), 20.0);
    }

    proptest! {
        /// The oracle goes on by a hundredth of a cell.
        #[test]
        fn a_ray_through_random_obstacles_ends_where_small_steps_do(
            cells in prop::collection::vec(prop::bool::weighted(0.03), 40 * 40),
            x in 0.0..40.0f32, y in 0.0..40.0f32, angle in -3.2..3.2f32,
        ) {
            let geometry = Geometry::new(40, 40, 0.1, (0.0, 0.0, 0.0)).expect("valid");
            let data: Vec<i8> = cells.iter().map(|&occupied| if occupied { 100 } else { 0 }).collect();
            let field = LikelihoodField::new(&OccupancyGrid::from_ros(geometry, &data).expect("as many"));
            let (sin, cos) = angle.sin_cos();
            let found = field.cast((x, y), (cos, sin), 60.0);
            let meets = |way: f32| field.parts(x + way * cos, y + way * sin) == 0;
            let first = (0..6000).map(|step| step as f32 / 100.0).find(|&way| meets(way));
            // It finds none earlier, and misses no more than a corner: what the ray meets for less than half a cell.
            prop_assert!(found >= first.unwrap_or(60.0) - 0.02);
            if let Some(first) = first.filter(|&first| found > first + 0.51) {
                prop_assert!((0..50).any(|step| !meets(first + step as f32 / 100.0)));
            }
        }
    }
}
