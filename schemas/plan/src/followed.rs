//! The costs of a map, of obstacles over it and of what is drawn on both, which follow all three: changed cells are
//! repaired, a map of another place or size begins anew. It plans nothing.

use std::collections::BTreeSet;

use jde_grid::{
    Cell, Costmap, Drawing, Geometry, GeometryError, Inflation, InflationError, Layers, Occupancy,
    OccupancyGrid as Grid,
};
use jde_schema::types::{OccupancyGrid, Pose2D};

/// Why a map cannot be used.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub(crate) enum MapError {
    /// The size, the resolution, the origin or the number of cells is wrong.
    #[error("{0}")]
    Geometry(#[from] GeometryError),
    /// The footprint is wrong.
    #[error("{0}")]
    Inflation(#[from] InflationError),
}

/// The costs of the newest map and drawing.
pub(crate) struct Followed {
    /// The map.
    known: Grid,
    /// The cells of obstacles that the map does not have.
    over: BTreeSet<Cell>,
    /// The map with those obstacles.
    grid: Grid,
    /// The costs of that.
    obstacles: Costmap,
    layers: Layers,
    inflation: Inflation,
    /// The map's number, so that the same map is not compared again.
    sequence: u64,
}

/// What has become of the costs.
pub(crate) enum Change {
    /// These cells have other costs.
    Cells(Vec<Cell>),
    /// All is new.
    All,
}

impl Followed {
    /// Follows the map with this number, and the drawing. Whatever was followed before is replaced if it had another place,
    /// size or inflation; after an error nothing is followed.
    pub(crate) fn follow(
        followed: &mut Option<Self>,
        (map, sequence): (&OccupancyGrid, u64),
        inflation: Inflation,
        drawing: Drawing,
    ) -> Result<Change, MapError> {
        let geometry = geometry(map).inspect_err(|_| *followed = None)?;
        if let Some(same) = followed
            && same.obstacles.geometry() == &geometry
            && same.inflation == inflation
        {
            let mut changed = same.repair(map, sequence);
            changed.extend(same.layers.draw(&same.obstacles, drawing));
            return Ok(Change::Cells(changed));
        }
        *followed = None;
        let grid = Grid::from_ros(geometry, &map.data)?;
        let obstacles = Costmap::new(&grid, &inflation)?;
        *followed = Some(Self {
            layers: Layers::new(&obstacles, drawing),
            obstacles,
            known: grid.clone(),
            over: BTreeSet::new(),
            grid,
            inflation,
            sequence,
        });
        Ok(Change::All)
    }

    /// The costs, with the drawing.
    pub(crate) const fn costs(&self) -> &Costmap {
        self.layers.costs()
    }

    /// The costs without the drawing.
    pub(crate) const fn obstacles(&self) -> &Costmap {
        &self.obstacles
    }

    /// Whether the centre of the robot is too close to a keep-out zone in this cell.
    pub(crate) fn is_in_zone(&self, cell: Cell) -> bool {
        self.layers.is_in_zone(cell)
    }

    /// Whether there are keep-out zones.
    pub(crate) const fn has_zones(&self) -> bool {
        !self.layers.drawing().zones.is_empty()
    }

    /// The map alone.
    pub(crate) const fn known(&self) -> &Grid {
        &self.known
    }

    /// Whether there are obstacles that the map does not have.
    pub(crate) fn has_seen_obstacles(&self) -> bool {
        !self.over.is_empty()
    }

    /// Puts obstacles in these cells over the map, in place of those before. Returns the cells whose costs have changed.
    pub(crate) fn put_over(&mut self, cells: BTreeSet<Cell>) -> Vec<Cell> {
        let before = core::mem::replace(&mut self.over, cells);
        let touched: Vec<Cell> = before.symmetric_difference(&self.over).copied().collect();
        self.compose(touched)
    }

    fn repair(&mut self, map: &OccupancyGrid, sequence: u64) -> Vec<Cell> {
        if core::mem::replace(&mut self.sequence, sequence) == sequence {
            return Vec::new();
        }
        let changed = self.known.take_ros(&map.data);
        self.compose(changed)
    }

    /// Makes these cells anew from the map and the obstacles over it. Returns the cells whose costs have changed.
    fn compose(&mut self, mut cells: Vec<Cell>) -> Vec<Cell> {
        cells.retain(|cell| {
            let state = match self.over.contains(cell) {
                true => Occupancy::Occupied,
                false => self.known.get(*cell),
            };
            self.grid.set(*cell, state)
        });
        let changed = self.obstacles.update(&self.grid, &cells);
        self.layers.update(&self.obstacles, &changed)
    }
}

/// Returns the states of the cells of a message.
pub(crate) fn grid(map: &OccupancyGrid) -> Result<Grid, GeometryError> {
    Grid::from_ros(geometry(map)?, &map.data)
}

/// The geometry of a map with as many cells as it states.
fn geometry(map: &OccupancyGrid) -> Result<Geometry, GeometryError> {
    let (info, origin) = (&map.info, Pose2D::from(map.info.origin));
    let origin = (origin.x, origin.y, origin.theta);
    Geometry::new(info.width, info.height, info.resolution.into(), origin)?.with_cells(map.data.len())
}
