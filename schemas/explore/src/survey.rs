//! A survey of a map: the ways from the robot to its frontiers. It takes as many iterations as the map is large, and chooses
//! nothing.

use jde_grid::costmap::LETHAL;
use jde_grid::{
    Cell, Costmap, Field, Geometry, Inflation, Occupancy, OccupancyGrid as Grid, PlanError, Prices, Unknown,
    frontiers, nearest_open,
};
use jde_schema::prelude::*;
use jde_schema::types::OccupancyGrid;

use super::GivenUp;

/// A survey under way.
pub(crate) struct Survey {
    grid: Grid,
    field: Field,
    begun: Duration,
}

/// A frontier.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Frontier {
    /// The length of what the robot can reach of it: cells times their side, m.
    pub(crate) size: f64,
    /// The centres of its cells, m.
    pub(crate) cells: Vec<(f64, f64)>,
    /// Where the robot would drive and the length of the way, m; `None` if what it can
    /// reach is too short.
    pub(crate) place: Option<(Pose2D, f64)>,
}

/// What a survey found.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Surveyed {
    /// When it began.
    pub(crate) begun: Duration,
    /// The frontiers that are long enough.
    pub(crate) frontiers: Vec<Frontier>,
    /// The area that is known to be free, m².
    pub(crate) area: f64,
}

impl Survey {
    /// Begins a survey from this place, for a robot of this radius. Nearer to an obstacle than the radius, the robot begins at
    /// the nearest place where it can be, at most the radius away.
    ///
    /// # Errors
    /// If the map or the radius is wrong, or the robot is outside the map, in an obstacle, or where nothing is known.
    pub(crate) fn new(map: &OccupancyGrid, robot: (f64, f64), radius: f64, now: Duration) -> Result<Self> {
        let (info, origin) = (&map.info, Pose2D::from(map.info.origin));
        let origin = (origin.x, origin.y, origin.theta);
        let geometry = Geometry::new(info.width, info.height, info.resolution.into(), origin)?;
        let grid = Grid::from_ros(geometry, &map.data)?;
        let costs = Costmap::new(&grid, &Inflation::circle(radius))?;
        let prices = Prices::new(0.0, Unknown::Closed);
        let robot = geometry.cell_at(robot).ok_or(PlanError::StartOutside)?;
        let reach = radius / geometry.resolution() + 2.0;
        let start = nearest_open(&costs, &prices, robot, reach).filter(|_| costs.get(robot) != LETHAL);
        let start = start.ok_or(PlanError::StartClosed)?;
        let field = Field::new(&costs, &prices, start)?;
        Ok(Self {
            grid,
            field,
            begun: now,
        })
    }

    /// Goes on by at most so many cells. Returns whether only [`Self::end`] is left.
    pub(crate) fn advance(&mut self, cells: u64) -> bool {
        self.field.settle_some(cells)
    }

    /// Returns the frontiers of at least this length in metres, without the cells within `apart` of what was given up. Forgets what
    /// was given up and has been seen since: on the map, without a cell of a frontier within `apart`.
    pub(crate) fn end(&self, least: f64, apart: f64, given_up: &mut Vec<GivenUp>) -> Surveyed {
        let geometry = *self.grid.geometry();
        let resolution = geometry.resolution();
        let free = self
            .grid
            .cells()
            .iter()
            .filter(|state| **state == Occupancy::Free)
            .count();
        let mut is_open: Vec<bool> = given_up
            .iter()
            .map(|past| geometry.cell_at(past.place).is_none())
            .collect();
        let mut is_left_out = |cell: (f64, f64)| {
            let mut is_left_out = false;
            for (past, is_open) in given_up.iter().zip(&mut is_open) {
                let is_near = past.is_near(cell, apart);
                *is_open |= is_near;
                is_left_out |= is_near;
            }
            is_left_out
        };
        let length = |cells: &[Cell]| cells.len() as f64 * resolution;
        let long = |mut cells: Vec<Cell>| {
            cells.retain(|&cell| !is_left_out(geometry.center(cell)));
            let fits = |cell: &Cell| self.field.price(*cell).is_some();
            let reached: Vec<Cell> = cells.iter().copied().filter(fits).collect();
            (length(&cells) >= least).then(|| Frontier {
                size: length(&reached),
                place: self.place(&reached).filter(|_| length(&reached) >= least),
                cells: cells.iter().map(|&cell| geometry.center(cell)).collect(),
            })
        };
        let long: Vec<Frontier> = frontiers(&self.grid).into_iter().filter_map(long).collect();
        let mut is_open = is_open.into_iter();
        given_up.retain(|_| is_open.next() == Some(true));
        Surveyed {
            begun: self.begun,
            frontiers: long,
            area: free as f64 * resolution * resolution,
        }
    }

    /// Whether a way leads to a place, m.
    pub(crate) fn reaches(&self, place: (f64, f64)) -> bool {
        let cell = self.grid.geometry().cell_at(place);
        cell.and_then(|cell| self.field.price(cell)).is_some()
    }

    /// Where the robot would drive, and the length of the way, m: to the nearest cell of these to their middle.
    fn place(&self, cells: &[Cell]) -> Option<(Pose2D, f64)> {
        let mean = |pick: fn(&Cell) -> u32| {
            cells.iter().map(|cell| f64::from(pick(cell))).sum::<f64>() / cells.len() as f64
        };
        let middle = (mean(|cell| cell.x), mean(|cell| cell.y));
        let away = |cell: &&Cell| libm::hypot(f64::from(cell.x) - middle.0, f64::from(cell.y) - middle.1);
        let place = cells.iter().min_by(|a, b| away(a).total_cmp(&away(b)))?;
        let (x, y) = self.grid.geometry().center(*place);
        let way = self.field.price(*place)? * self.grid.geometry().resolution();
        Some((Pose2D::new(x, y, 0.0), way))
    }
}

impl Frontier {
    /// Whether a cell of it is within `distance` of a place, m.
    pub(crate) fn is_near(&self, (x, y): (f64, f64), distance: f64) -> bool {
        self.cells
            .iter()
            .any(|cell| libm::hypot(cell.0 - x, cell.1 - y) <= distance)
    }
}
