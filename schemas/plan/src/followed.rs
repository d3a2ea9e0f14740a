//! The costs of a map, which follow it: changed cells are repaired, a map of another place or size begins
//! anew. It plans nothing.

use jde_grid::{
    Cell, Costmap, Geometry, GeometryError, Inflation, InflationError, Occupancy, OccupancyGrid as Grid,
};
use jde_schema::types::OccupancyGrid;

/// Why a map cannot be used.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub(crate) enum MapError {
    /// The size, the resolution or the origin is wrong.
    #[error("{0}")]
    Geometry(#[from] GeometryError),
    /// The data have not the size that the map states.
    #[error("the map has {given} of {expected} cells")]
    Cells {
        /// How many there are.
        given: usize,
        /// How many its size requires.
        expected: usize,
    },
    /// The footprint is wrong.
    #[error("{0}")]
    Inflation(#[from] InflationError),
}

/// The costs of the newest map.
pub(crate) struct Followed {
    grid: Grid,
    costs: Costmap,
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
    /// Follows the map with this number. Whatever was followed before is replaced if it had another place,
    /// size or inflation; after an error nothing is followed.
    pub(crate) fn follow(
        followed: &mut Option<Self>,
        (map, sequence): (&OccupancyGrid, u64),
        inflation: Inflation,
    ) -> Result<Change, MapError> {
        let geometry = geometry(map).inspect_err(|_| *followed = None)?;
        if let Some(same) = followed
            && same.costs.geometry() == &geometry
            && same.inflation == inflation
        {
            return Ok(Change::Cells(same.repair(map, sequence)));
        }
        *followed = None;
        let grid = Grid::from_ros(geometry, &map.data).ok_or_else(|| cells(map, &geometry))?;
        *followed = Some(Self {
            costs: Costmap::new(&grid, &inflation)?,
            grid,
            inflation,
            sequence,
        });
        Ok(Change::All)
    }

    /// The costs.
    pub(crate) const fn costs(&self) -> &Costmap {
        &self.costs
    }

    fn repair(&mut self, map: &OccupancyGrid, sequence: u64) -> Vec<Cell> {
        if core::mem::replace(&mut self.sequence, sequence) == sequence {
            return Vec::new();
        }
        let geometry = *self.costs.geometry();
        let mut changed = Vec::new();
        for (index, &number) in map.data.iter().enumerate() {
            let cell = geometry.cell(index);
            if self.grid.set(cell, Occupancy::from_ros(number)) {
                changed.push(cell);
            }
        }
        self.costs.update(&self.grid, &changed)
    }
}

/// The geometry of a map with as many cells as it states.
fn geometry(map: &OccupancyGrid) -> Result<Geometry, MapError> {
    let (info, origin) = (&map.info, &map.info.origin);
    let place = (origin.position.x, origin.position.y, origin.orientation.yaw());
    let geometry = Geometry::new(info.width, info.height, f64::from(info.resolution), place)?;
    if map.data.len() == geometry.cells() {
        Ok(geometry)
    } else {
        Err(cells(map, &geometry))
    }
}

fn cells(map: &OccupancyGrid, geometry: &Geometry) -> MapError {
    MapError::Cells {
        given: map.data.len(),
        expected: geometry.cells(),
    }
}
