//! Occupancy grids: which cells are free, occupied or unknown. They do not know how sure a cell is.

use crate::geometry::{Cell, Geometry, GeometryError};

/// What is known of a cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Occupancy {
    /// Nothing stands there.
    Free,
    /// Something stands there.
    Occupied,
    /// Nothing is known of the cell.
    Unknown,
}

/// ROS's number for a free cell.
const FREE: i8 = 0;
/// ROS's number for an occupied cell, a probability in percent.
const OCCUPIED: i8 = 100;
/// ROS's number for an unknown cell.
const UNKNOWN: i8 = -1;
/// From this probability in percent on, a cell counts as occupied: the default of ROS's map server.
const OCCUPIED_FROM: i8 = 65;
/// Up to this probability in percent, a cell counts as free: below the default of ROS's map server, 19.6 %.
const FREE_UP_TO: i8 = 19;

impl Occupancy {
    /// Returns the state for a number of `nav_msgs/OccupancyGrid`: a probability in percent, or -1. Numbers
    /// that the message does not define are unknown.
    #[must_use]
    pub const fn from_ros(number: i8) -> Self {
        match number {
            0..=FREE_UP_TO => Self::Free,
            OCCUPIED_FROM..=100 => Self::Occupied,
            i8::MIN..=-1 | 20..=64 | 101..=i8::MAX => Self::Unknown,
        }
    }

    /// Returns the number of `nav_msgs/OccupancyGrid` for the state.
    #[must_use]
    pub const fn to_ros(self) -> i8 {
        match self {
            Self::Free => FREE,
            Self::Occupied => OCCUPIED,
            Self::Unknown => UNKNOWN,
        }
    }
}

/// The occupancy of every cell.
#[derive(Clone, Debug, PartialEq)]
pub struct OccupancyGrid {
    geometry: Geometry,
    cells: Vec<Occupancy>,
}

impl OccupancyGrid {
    /// Returns a grid whose cells are all in this state.
    #[must_use]
    pub fn filled(geometry: Geometry, state: Occupancy) -> Self {
        Self {
            geometry,
            cells: vec![state; geometry.cells()],
        }
    }

    /// Returns a grid with the numbers of `nav_msgs/OccupancyGrid`, row by row from the origin.
    ///
    /// # Errors
    /// If there are not as many as cells.
    pub fn from_ros(geometry: Geometry, data: &[i8]) -> Result<Self, GeometryError> {
        Ok(Self {
            geometry: geometry.with_cells(data.len())?,
            cells: data.iter().map(|&number| Occupancy::from_ros(number)).collect(),
        })
    }

    /// Takes the numbers of a newer message. Returns the cells whose states have changed.
    ///
    /// # Panics
    /// If there are not as many as cells.
    pub fn take_ros(&mut self, data: &[i8]) -> Vec<Cell> {
        assert_eq!(data.len(), self.cells.len(), "a number for each cell");
        let width = self.geometry.width() as usize;
        let rows = self.cells.chunks_exact_mut(width).zip(data.chunks_exact(width));
        let mut changed = Vec::new();
        for ((states, numbers), y) in rows.zip(0..) {
            // Most rows of a large map stay, and the compiler uses the vector unit for this.
            let pairs = states.iter().zip(numbers);
            if !pairs.fold(false, |any, (state, &number)| {
                any | (*state != Occupancy::from_ros(number))
            }) {
                continue;
            }
            for ((state, &number), x) in states.iter_mut().zip(numbers).zip(0..) {
                let newer = Occupancy::from_ros(number);
                if core::mem::replace(state, newer) != newer {
                    changed.push(Cell::new(x, y));
                }
            }
        }
        changed
    }

    /// Returns size, resolution and origin.
    #[must_use]
    pub const fn geometry(&self) -> &Geometry {
        &self.geometry
    }

    /// Returns the state of a cell; outside the grid it is unknown.
    #[must_use]
    pub fn get(&self, cell: Cell) -> Occupancy {
        if self.geometry.contains(cell) {
            self.cells[self.geometry.index(cell)]
        } else {
            Occupancy::Unknown
        }
    }

    /// Changes the state of a cell, and returns whether it was another. Outside the grid nothing changes.
    pub fn set(&mut self, cell: Cell, state: Occupancy) -> bool {
        let inside = self.geometry.contains(cell);
        inside && core::mem::replace(&mut self.cells[self.geometry.index(cell)], state) != state
    }

    /// Returns the states row by row from the origin.
    #[must_use]
    pub fn cells(&self) -> &[Occupancy] {
        &self.cells
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_numbers_of_ros_are_read_by_the_thresholds_of_its_map_server() {
        for (number, state) in [
            (-1, Occupancy::Unknown),
            (0, Occupancy::Free),
            (19, Occupancy::Free),
            (20, Occupancy::Unknown),
            (64, Occupancy::Unknown),
            (65, Occupancy::Occupied),
            (100, Occupancy::Occupied),
            (101, Occupancy::Unknown),
            (i8::MIN, Occupancy::Unknown),
        ] {
            assert_eq!(Occupancy::from_ros(number), state, "{number}");
        }
        for state in [Occupancy::Free, Occupancy::Occupied, Occupancy::Unknown] {
            assert_eq!(Occupancy::from_ros(state.to_ros()), state);
        }
    }

    #[test]
    fn a_newer_message_changes_the_cells_that_differ() {
        let geometry = Geometry::new(3, 2, 0.1, (0.0, 0.0, 0.0)).expect("valid");
        let mut grid = OccupancyGrid::from_ros(geometry, &[0, 100, -1, 0, 0, 0]).expect("as many as cells");
        let newer = [0, 0, -1, 0, 7, 30];
        assert_eq!(grid.take_ros(&newer), [Cell::new(1, 0), Cell::new(2, 1)]);
        assert_eq!(Ok(grid), OccupancyGrid::from_ros(geometry, &newer));
    }

    #[test]
    fn cells_outside_are_unknown_and_cannot_be_set() {
        let geometry = Geometry::new(1, 1, 0.1, (0.0, 0.0, 0.0)).expect("valid");
        let mut grid = OccupancyGrid::filled(geometry, Occupancy::Free);
        let outside = Cell::new(1, 0);
        assert!(!grid.set(outside, Occupancy::Occupied));
        assert_eq!(grid.get(outside), Occupancy::Unknown);
        assert!(grid.set(Cell::new(0, 0), Occupancy::Occupied));
        assert!(!grid.set(Cell::new(0, 0), Occupancy::Occupied), "no change");
        let error = OccupancyGrid::from_ros(geometry, &[0, 0]).expect_err("two numbers");
        assert_eq!(error.to_string(), "the map has 2 of 1 cells");
    }
}
