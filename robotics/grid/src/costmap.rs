//! Costmaps: what it costs the centre of the robot to be in a cell, from the distance to the nearest obstacle.
//! The numbers are those of ROS's `costmap_2d`.
//!
//! It counts occupied cells as obstacles and keeps unknown ones unknown; whether a robot may enter these is
//! the planner's matter.

use crate::distance::Distances;
use crate::geometry::{Cell, Geometry};
use crate::occupancy::{Occupancy, OccupancyGrid};
use crate::window::Window;

/// The cost of an unknown cell.
pub const UNKNOWN: u8 = 255;
/// The cost of an obstacle.
pub const LETHAL: u8 = 254;
/// The cost where the robot touches an obstacle whatever its heading.
pub const INSCRIBED: u8 = 253;
/// The greatest cost of a cell where the robot may be.
pub const MAX_PASSABLE: u8 = 252;

/// The longest reach of an inflation, in cells: its table of costs then takes a megabyte at most.
const MAX_REACH_CELLS: f64 = 1024.0;

/// What distances may lose by rounding, in metres: a cell at the very edge of a radius belongs to it.
const ROUNDING: f64 = 1e-9;

/// How costs decay around obstacles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Inflation {
    /// Radius of the largest circle within the footprint, in metres.
    pub inscribed: f64,
    /// Radius of the smallest circle around the footprint, in metres.
    pub circumscribed: f64,
    /// Distance to an obstacle from which on nothing costs, in metres. If it is below `circumscribed`, this
    /// is the reach.
    pub reach: f64,
    /// Rate at which costs decay beyond the inscribed radius, in 1/m: by a factor of e every 1/`decay` metres.
    pub decay: f64,
}

/// Why an inflation is refused.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error(
    "the inflation {0:?} is refused: expected 0 <= inscribed <= circumscribed, decay >= 0, and a reach of at most {MAX_REACH_CELLS} cells"
)]
pub struct InflationError(Inflation);

impl Inflation {
    /// Returns that of a robot which is a circle of this radius in metres. Nothing costs beyond it.
    #[must_use]
    pub const fn circle(radius: f64) -> Self {
        Self {
            inscribed: radius,
            circumscribed: radius,
            reach: radius,
            decay: 0.0,
        }
    }

    /// Returns the cost at this distance in metres to the nearest obstacle: ROS's formula,
    /// 252 · e^(−decay · (distance − inscribed)) beyond the inscribed radius.
    #[must_use]
    pub fn cost(&self, distance: f64) -> u8 {
        if distance <= 0.0 {
            LETHAL
        } else if distance <= self.inscribed + ROUNDING {
            INSCRIBED
        } else if distance <= self.reach.max(self.circumscribed) + ROUNDING {
            let factor = libm::exp(-self.decay * (distance - self.inscribed));
            (factor * f64::from(MAX_PASSABLE)) as u8
        } else {
            0
        }
    }

    /// Returns the cost at the circumscribed radius. Where a cell costs less, the robot touches nothing
    /// whatever its heading.
    #[must_use]
    pub fn circumscribed_cost(&self) -> u8 {
        self.cost(self.circumscribed)
    }

    /// Returns the costs by the square of the distance in cells.
    fn table(&self, resolution: f64) -> Result<Vec<u8>, InflationError> {
        let ordered = 0.0 <= self.inscribed && self.inscribed <= self.circumscribed;
        let cells = (self.reach.max(self.circumscribed) + ROUNDING) / resolution;
        // A comparison with NaN is false, so that NaN is refused.
        if !(ordered && self.decay >= 0.0 && self.reach >= 0.0 && cells <= MAX_REACH_CELLS) {
            return Err(InflationError(*self));
        }
        let last = libm::floor(cells * cells) as u32;
        Ok((0..=last)
            .map(|square| self.cost(libm::sqrt(f64::from(square)) * resolution))
            .collect())
    }
}

/// The cost of every cell.
#[derive(Clone, Debug, PartialEq)]
pub struct Costmap {
    geometry: Geometry,
    costs: Vec<u8>,
    /// Costs by the square of the distance in cells; beyond its end nothing costs.
    table: Vec<u8>,
}

impl Costmap {
    /// Returns the costs of this grid.
    ///
    /// # Errors
    /// If the inflation's numbers are not finite, negative, out of order, or reach too far.
    pub fn new(grid: &OccupancyGrid, inflation: &Inflation) -> Result<Self, InflationError> {
        let geometry = *grid.geometry();
        let mut costmap = Self {
            geometry,
            costs: vec![UNKNOWN; geometry.cells()],
            table: inflation.table(geometry.resolution())?,
        };
        // Beyond the reach of what is known, all is unknown.
        if let Some(known) = Window::known(grid) {
            costmap.refresh(grid, known.grown(costmap.reach(), &geometry), |_| {});
        }
        Ok(costmap)
    }

    /// Returns a costmap with these costs and no inflation.
    #[cfg(test)]
    pub(crate) fn with_costs(geometry: Geometry, costs: &[u8]) -> Self {
        Self {
            geometry,
            costs: costs.to_vec(),
            table: vec![LETHAL],
        }
    }

    /// Follows changes of `changed` cells of the grid, and returns the cells whose costs have changed. Equals
    /// a new costmap; takes time by the box around the changes and the reach of the inflation.
    ///
    /// # Panics
    /// If the grid has another geometry.
    pub fn update(&mut self, grid: &OccupancyGrid, changed: &[Cell]) -> Vec<Cell> {
        assert_eq!(grid.geometry(), &self.geometry, "the grid that it was made from");
        let (geometry, mut cells) = (self.geometry, Vec::new());
        if let Some(window) = Window::around(changed, &self.geometry) {
            self.refresh(grid, window.grown(self.reach(), &self.geometry), |index| {
                cells.push(geometry.cell(index));
            });
        }
        cells
    }

    /// Returns size, resolution and origin.
    #[must_use]
    pub const fn geometry(&self) -> &Geometry {
        &self.geometry
    }

    /// Returns the cost of a cell; outside the grid it is unknown.
    #[must_use]
    pub fn get(&self, cell: Cell) -> u8 {
        if self.geometry.contains(cell) {
            self.costs[self.geometry.index(cell)]
        } else {
            UNKNOWN
        }
    }

    /// Sets the cost of a cell of the grid. Returns whether it was another one.
    pub(crate) fn set(&mut self, cell: Cell, cost: u8) -> bool {
        let place = &mut self.costs[self.geometry.index(cell)];
        core::mem::replace(place, cost) != cost
    }

    /// Returns the costs row by row from the origin.
    #[must_use]
    pub fn costs(&self) -> &[u8] {
        &self.costs
    }

    /// The reach of the table in whole cells, rounded up.
    fn reach(&self) -> u32 {
        libm::ceil(libm::sqrt(self.table.len() as f64)) as u32
    }

    /// Computes the costs of a window, from the obstacles in it and within reach of it, and states which have changed.
    fn refresh(&mut self, grid: &OccupancyGrid, window: Window, mut changed: impl FnMut(usize)) {
        let seen = window.grown(self.reach(), &self.geometry);
        let mut obstacles = Vec::with_capacity(seen.width() * seen.height());
        for row in seen.rows(&self.geometry) {
            let states = grid.cells()[row].iter();
            obstacles.extend(states.map(|state| *state == Occupancy::Occupied));
        }
        let mut distances = Distances::default();
        let squares = distances.squared_within(seen.width(), &obstacles, self.table.len() as u32 - 1);
        let (aside, below) = seen.offset(&window);
        for (row, squares) in window
            .rows(&self.geometry)
            .zip(squares.chunks_exact(seen.width()).skip(below))
        {
            let cells = row.clone().zip(&mut self.costs[row.clone()]);
            for (((index, place), state), &square) in cells.zip(&grid.cells()[row]).zip(&squares[aside..]) {
                let by_distance = self.table.get(square as usize).copied().unwrap_or(0);
                let is_unknown = *state == Occupancy::Unknown && by_distance < INSCRIBED;
                let cost = if is_unknown { UNKNOWN } else { by_distance };
                if *place != cost {
                    *place = cost;
                    changed(index);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    const INFLATION: Inflation = Inflation {
        inscribed: 0.2,
        circumscribed: 0.3,
        reach: 0.5,
        decay: 5.0,
    };

    fn grid(width: u32, height: u32, occupied: &[(u32, u32)]) -> OccupancyGrid {
        let geometry = Geometry::new(width, height, 0.1, (0.0, 0.0, 0.0)).expect("valid");
        let mut grid = OccupancyGrid::filled(geometry, Occupancy::Free);
        for &(x, y) in occupied {
            grid.set(Cell::new(x, y), Occupancy::Occupied);
        }
        grid
    }

    #[test]
    fn a_cell_at_the_very_edge_of_a_radius_belongs_to_it() {
        let inflation = Inflation {
            inscribed: 0.3,
            ..INFLATION
        };
        let costmap = Costmap::new(&grid(7, 1, &[(0, 0)]), &inflation).expect("valid");
        assert_eq!(costmap.costs()[..4], [LETHAL, INSCRIBED, INSCRIBED, INSCRIBED]);
        assert_ne!(costmap.costs()[5], 0);
        assert_eq!(costmap.costs()[6], 0);
    }

    #[test]
    fn costs_decay_with_the_distance_to_an_obstacle() {
        let costmap = Costmap::new(&grid(10, 1, &[(0, 0)]), &INFLATION).expect("valid");
        // Beyond 0.2 m: 252 e^(-0.5), e^(-1), e^(-1.5).
        assert_eq!(
            costmap.costs(),
            [LETHAL, INSCRIBED, INSCRIBED, 152, 92, 56, 0, 0, 0, 0]
        );
        assert_eq!(INFLATION.circumscribed_cost(), 152);
    }

    #[test]
    fn unknown_cells_stay_unknown_unless_the_robot_would_touch_an_obstacle() {
        let mut grid = grid(6, 1, &[(0, 0)]);
        for x in 1..6 {
            grid.set(Cell::new(x, 0), Occupancy::Unknown);
        }
        let costmap = Costmap::new(&grid, &INFLATION).expect("valid");
        assert_eq!(
            costmap.costs(),
            [LETHAL, INSCRIBED, INSCRIBED, UNKNOWN, UNKNOWN, UNKNOWN]
        );
        assert_eq!(costmap.get(Cell::new(6, 0)), UNKNOWN, "outside");
    }

    #[test]
    fn numbers_that_no_footprint_has_are_refused() {
        let grid = grid(1, 1, &[]);
        for wrong in [
            Inflation {
                inscribed: f64::NAN,
                ..INFLATION
            },
            Inflation {
                inscribed: 0.4,
                ..INFLATION
            },
            Inflation {
                inscribed: -0.1,
                ..INFLATION
            },
            Inflation {
                reach: f64::INFINITY,
                ..INFLATION
            },
            Inflation {
                reach: f64::NAN,
                ..INFLATION
            },
            Inflation {
                decay: -1.0,
                ..INFLATION
            },
            Inflation {
                circumscribed: 1e6,
                ..INFLATION
            },
        ] {
            assert!(Costmap::new(&grid, &wrong).is_err(), "{wrong:?}");
        }
        assert!(Costmap::new(&grid, &INFLATION).is_ok());
    }

    proptest! {
        #[test]
        fn an_update_equals_a_new_costmap(
            first in prop::collection::vec((0u32..40, 0u32..30), 0..40),
            changes in prop::collection::vec((0u32..42, 0u32..32, 0u8..3), 0..12),
        ) {
            let mut grid = grid(40, 30, &first);
            let mut costmap = Costmap::new(&grid, &INFLATION).expect("valid");
            let before = costmap.clone();
            let cells: Vec<Cell> = changes
                .into_iter()
                .map(|(x, y, state)| {
                    let cell = Cell::new(x, y);
                    let states = [Occupancy::Free, Occupancy::Occupied, Occupancy::Unknown];
                    grid.set(cell, states[usize::from(state)]);
                    cell
                })
                .collect();
            let changed = costmap.update(&grid, &cells);
            prop_assert_eq!(&costmap, &Costmap::new(&grid, &INFLATION).expect("valid"));
            let differing = costmap.costs().iter().zip(before.costs()).filter(|(a, b)| a != b).count();
            prop_assert_eq!(changed.len(), differing);
        }
    }
}
