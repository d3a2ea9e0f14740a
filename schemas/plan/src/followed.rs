//! The costs of a map and of what is drawn on it, which follow both: changed cells are repaired, a map of another
//! place or size begins anew. It plans nothing.

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
    grid: Grid,
    /// The costs of the map alone.
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

    fn repair(&mut self, map: &OccupancyGrid, sequence: u64) -> Vec<Cell> {
        if core::mem::replace(&mut self.sequence, sequence) == sequence {
            return Vec::new();
        }
        let geometry = *self.obstacles.geometry();
        let mut changed = Vec::new();
        for (index, &number) in map.data.iter().enumerate() {
            let cell = geometry.cell(index);
            if self.grid.set(cell, Occupancy::from_ros(number)) {
                changed.push(cell);
            }
        }
        let changed = self.obstacles.update(&self.grid, &changed);
        self.layers.update(&self.obstacles, &changed)
    }
}

/// The geometry of a map with as many cells as it states.
fn geometry(map: &OccupancyGrid) -> Result<Geometry, GeometryError> {
    let (info, origin) = (&map.info, Pose2D::from(map.info.origin));
    let origin = (origin.x, origin.y, origin.theta);
    Geometry::new(info.width, info.height, info.resolution.into(), origin)?.with_cells(map.data.len())
}
