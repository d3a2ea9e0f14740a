//! Where the cells of a grid are: its size, its resolution and its origin in the world.
//!
//! It refuses sizes and numbers that no map has, so that all later arithmetic stays finite.

/// The most cells of a grid: 4096 × 4096, so that maps of 200 m at 5 cm fit and indices fit into 32 bits.
pub const MAX_CELLS: usize = 4096 * 4096;

/// The steps to the four sides of a cell.
pub(crate) const SIDES: [(i32, i32); 4] = [(1, 0), (0, 1), (-1, 0), (0, -1)];

/// The farthest origin from zero, in metres. A cell is then still exact to a nanometre.
const FARTHEST: f64 = 1e6;

/// A cell by its column and row, counted from the origin: `x` along the grid's x axis, `y` along its y axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Cell {
    /// The column.
    pub x: u32,
    /// The row.
    pub y: u32,
}

impl Cell {
    /// Returns the cell in this column and row.
    #[must_use]
    pub const fn new(x: u32, y: u32) -> Self {
        Self { x, y }
    }

    /// Returns the cell this many columns and rows away; `None` below zero.
    #[must_use]
    pub fn offset(self, dx: i32, dy: i32) -> Option<Self> {
        Some(Self {
            x: self.x.checked_add_signed(dx)?,
            y: self.y.checked_add_signed(dy)?,
        })
    }

    /// Returns the distance between the centres of two cells, in cells.
    #[must_use]
    pub fn distance(self, other: Self) -> f64 {
        let dx = f64::from(self.x.abs_diff(other.x));
        let dy = f64::from(self.y.abs_diff(other.y));
        libm::sqrt(dx * dx + dy * dy)
    }
}

/// Why a grid cannot have this geometry.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum GeometryError {
    /// There is no cell, or there are more than [`MAX_CELLS`].
    #[error("the grid has {width} x {height} cells: expected 1 to {MAX_CELLS} in all")]
    Size {
        /// Columns.
        width: u32,
        /// Rows.
        height: u32,
    },
    /// The resolution is not a length from 1 mm to 1 km.
    #[error("the resolution is {0} m: expected 0.001 to 1000")]
    Resolution(f64),
    /// The origin is not finite, or is too far from zero.
    #[error("the origin is ({x}, {y}) m, {yaw} rad: expected finite numbers, up to {FARTHEST} m")]
    Origin {
        /// x in metres.
        x: f64,
        /// y in metres.
        y: f64,
        /// Heading of the grid's x axis, rad.
        yaw: f64,
    },
    /// There are more or fewer numbers than cells.
    #[error("the map has {given} of {expected} cells")]
    Cells {
        /// How many there are.
        given: usize,
        /// How many the size requires.
        expected: usize,
    },
}

/// Size, resolution and origin of a grid, as in ROS's `nav_msgs/MapMetaData`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Geometry {
    width: u32,
    height: u32,
    resolution: f64,
    x: f64,
    y: f64,
    yaw: f64,
    sin: f64,
    cos: f64,
}

impl Geometry {
    /// Returns the geometry of `width` × `height` cells with sides of `resolution` metres, whose lower left
    /// corner is at the origin (x, y, yaw) in metres and radians.
    ///
    /// # Errors
    /// If the size, the resolution or the origin is out of range or not finite.
    pub fn new(
        width: u32,
        height: u32,
        resolution: f64,
        (x, y, yaw): (f64, f64, f64),
    ) -> Result<Self, GeometryError> {
        let cells = width as usize * height as usize;
        if cells == 0 || cells > MAX_CELLS {
            return Err(GeometryError::Size { width, height });
        }
        if !(1e-3..=1e3).contains(&resolution) {
            return Err(GeometryError::Resolution(resolution));
        }
        if !(x.abs() <= FARTHEST && y.abs() <= FARTHEST && yaw.is_finite()) {
            return Err(GeometryError::Origin { x, y, yaw });
        }
        let (sin, cos) = libm::sincos(yaw);
        Ok(Self {
            width,
            height,
            resolution,
            x,
            y,
            yaw,
            sin,
            cos,
        })
    }

    /// Returns the geometry if its cells are so many.
    ///
    /// # Errors
    /// If there are more or fewer.
    pub const fn with_cells(self, given: usize) -> Result<Self, GeometryError> {
        let expected = self.cells();
        if given == expected {
            Ok(self)
        } else {
            Err(GeometryError::Cells { given, expected })
        }
    }

    /// Returns the number of columns.
    #[must_use]
    pub const fn width(&self) -> u32 {
        self.width
    }

    /// Returns the number of rows.
    #[must_use]
    pub const fn height(&self) -> u32 {
        self.height
    }

    /// Returns the side of a cell in metres.
    #[must_use]
    pub const fn resolution(&self) -> f64 {
        self.resolution
    }

    /// Returns the lower left corner in metres, and the heading of the x axis in radians.
    #[must_use]
    pub const fn origin(&self) -> (f64, f64, f64) {
        (self.x, self.y, self.yaw)
    }

    /// Returns the number of cells.
    #[must_use]
    pub const fn cells(&self) -> usize {
        self.width as usize * self.height as usize
    }

    /// Returns whether the cell is in the grid.
    #[must_use]
    pub const fn contains(&self, cell: Cell) -> bool {
        cell.x < self.width && cell.y < self.height
    }

    /// Returns whether the cell is one of the outermost cells of the grid.
    #[must_use]
    pub const fn is_on_edge(&self, cell: Cell) -> bool {
        self.contains(cell)
            && (cell.x == 0 || cell.y == 0 || cell.x + 1 == self.width || cell.y + 1 == self.height)
    }

    /// Returns the place of a cell of the grid in its data: row by row, as in ROS.
    #[must_use]
    pub const fn index(&self, cell: Cell) -> usize {
        cell.y as usize * self.width as usize + cell.x as usize
    }

    /// Returns the cell at a place of the data, the inverse of [`Geometry::index`].
    #[must_use]
    pub const fn cell(&self, index: usize) -> Cell {
        Cell {
            x: (index % self.width as usize) as u32,
            y: (index / self.width as usize) as u32,
        }
    }

    /// Converts a point of the world, in metres, to columns and rows with fractions. A whole number is the
    /// edge of a cell, and its centre is half a cell farther.
    #[must_use]
    pub fn to_grid(&self, (x, y): (f64, f64)) -> (f64, f64) {
        let (dx, dy) = (x - self.x, y - self.y);
        let along = self.cos * dx + self.sin * dy;
        let across = self.cos * dy - self.sin * dx;
        (along / self.resolution, across / self.resolution)
    }

    /// Converts columns and rows with fractions to a point of the world in metres, the inverse of
    /// [`Geometry::to_grid`].
    #[must_use]
    pub fn to_world(&self, (column, row): (f64, f64)) -> (f64, f64) {
        let (along, across) = (column * self.resolution, row * self.resolution);
        (
            self.x + self.cos * along - self.sin * across,
            self.y + self.sin * along + self.cos * across,
        )
    }

    /// Returns the cell at a point of the world in metres; `None` outside the grid and for numbers that are
    /// not finite.
    #[must_use]
    pub fn cell_at(&self, point: (f64, f64)) -> Option<Cell> {
        let (column, row) = self.to_grid(point);
        let inside = |value: f64, size: u32| value >= 0.0 && value < f64::from(size);
        (inside(column, self.width) && inside(row, self.height)).then(|| Cell::new(column as u32, row as u32))
    }

    /// Returns the centre of a cell in the world, in metres.
    #[must_use]
    pub fn center(&self, cell: Cell) -> (f64, f64) {
        self.to_world((f64::from(cell.x) + 0.5, f64::from(cell.y) + 0.5))
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn sizes_and_numbers_that_no_map_has_are_refused() {
        let at = (0.0, 0.0, 0.0);
        for (width, height) in [(0, 5), (5, 0), (4097, 4096), (u32::MAX, u32::MAX)] {
            let error = Geometry::new(width, height, 0.05, at);
            assert_eq!(error, Err(GeometryError::Size { width, height }));
        }
        for resolution in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            let error = Geometry::new(1, 1, resolution, at).expect_err("refused");
            assert!(matches!(error, GeometryError::Resolution(_)), "{error}");
        }
        for origin in [(f64::NAN, 0.0, 0.0), (0.0, 1e9, 0.0), (0.0, 0.0, f64::INFINITY)] {
            let error = Geometry::new(1, 1, 0.05, origin).expect_err("refused");
            assert!(matches!(error, GeometryError::Origin { .. }), "{error}");
        }
    }

    #[test]
    fn points_outside_have_no_cell() {
        let geometry = Geometry::new(2, 1, 0.5, (1.0, -1.0, 0.0)).expect("valid");
        assert_eq!(geometry.cell_at((1.0, -1.0)), Some(Cell::new(0, 0)));
        assert_eq!(geometry.cell_at((1.99, -0.51)), Some(Cell::new(1, 0)));
        for point in [
            (0.99, -0.9),
            (2.0, -0.9),
            (1.1, -0.5),
            (f64::NAN, 0.0),
            (f64::INFINITY, 0.0),
        ] {
            assert_eq!(geometry.cell_at(point), None, "{point:?}");
        }
    }

    #[test]
    fn a_quarter_turn_of_the_origin_turns_the_axes() {
        let geometry = Geometry::new(4, 2, 1.0, (0.0, 0.0, core::f64::consts::FRAC_PI_2)).expect("valid");
        let (x, y) = geometry.center(Cell::new(3, 1));
        assert!((x + 1.5).abs() < 1e-12 && (y - 3.5).abs() < 1e-12, "{x}, {y}");
    }

    proptest! {
        #[test]
        fn the_cell_at_the_centre_of_a_cell_is_this_cell(
            x in 0u32..400, y in 0u32..300, yaw in -4.0..4.0f64, resolution in 0.01..2.0f64,
        ) {
            let geometry = Geometry::new(400, 300, resolution, (-7.0, 3.0, yaw)).expect("valid");
            let cell = Cell::new(x, y);
            prop_assert_eq!(geometry.cell_at(geometry.center(cell)), Some(cell));
            prop_assert_eq!(geometry.cell(geometry.index(cell)), cell);
        }
    }
}
