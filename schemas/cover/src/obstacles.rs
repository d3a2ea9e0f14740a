//! The obstacles of the map, and those over it that are seen and that the map does not have.

use std::collections::BTreeSet;

use jde_grid::{Cell, Geometry, GeometryError, Occupancy, OccupancyGrid as Grid, SeenObstacles};
use jde_schema::prelude::*;
use jde_schema::types::OccupancyGrid;

/// What was seen over the newest map.
pub(crate) struct Obstacles {
    /// The number of the map.
    sequence: u64,
    known: Grid,
    seen: SeenObstacles,
    /// The number of the last view.
    view: Option<u64>,
    /// The cells of what was seen.
    over: BTreeSet<Cell>,
    /// The map with these cells.
    grid: Grid,
}

/// Where the robot is, and for how long it remembers.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Standpoint {
    /// The place of the robot, m.
    pub(crate) robot: (f64, f64),
    /// There is no obstacle within this radius of it, m.
    pub(crate) radius: f64,
    pub(crate) now: Duration,
    /// What was seen last before this is forgotten.
    pub(crate) since: Duration,
}

impl Obstacles {
    pub(crate) fn new(map: &OccupancyGrid, sequence: u64) -> Result<Self, GeometryError> {
        let known = grid(map)?;
        Ok(Self {
            sequence,
            seen: SeenObstacles::new(known.geometry().resolution()),
            view: None,
            over: BTreeSet::new(),
            grid: known.clone(),
            known,
        })
    }

    /// Follows a map of another number. What was seen stays, unless the cells have another size.
    pub(crate) fn follow(&mut self, map: &OccupancyGrid, sequence: u64) -> Result<(), GeometryError> {
        if self.sequence == sequence {
            return Ok(());
        }
        let mut next = Self::new(map, sequence)?;
        if next.seen.resolution() == self.seen.resolution() {
            core::mem::swap(&mut next.seen, &mut self.seen);
            next.view = self.view;
        }
        *self = next;
        self.put_over();
        Ok(())
    }

    /// Takes in a view of this number, in the frame of the map, and forgets what was seen long ago.
    pub(crate) fn look(
        &mut self,
        view: Option<(&OccupancyGrid, u64)>,
        from: &Standpoint,
    ) -> Result<(), GeometryError> {
        if let Some((view, sequence)) = view
            && self.view.replace(sequence) != Some(sequence)
        {
            self.seen.observe(&self.known, &grid(view)?, from.now);
        }
        self.seen.forget(from.since);
        self.seen.forget_around(from.robot, from.radius);
        self.put_over();
        Ok(())
    }

    /// Forgets all that was seen, as after a jump of the pose: it was elsewhere.
    pub(crate) fn forget(&mut self) {
        self.seen = SeenObstacles::new(self.seen.resolution());
    }

    /// Returns the map without what was seen.
    pub(crate) const fn known(&self) -> &Grid {
        &self.known
    }

    /// Returns the map with what was seen.
    pub(crate) const fn grid(&self) -> &Grid {
        &self.grid
    }

    /// Returns the cells of what was seen.
    pub(crate) const fn over(&self) -> &BTreeSet<Cell> {
        &self.over
    }

    fn put_over(&mut self) {
        // Where it was seen, it is known to a cell.
        let near = [(0, 0), (1, 0), (-1, 0), (0, 1), (0, -1)];
        let geometry = *self.known.geometry();
        let around = |cell: Cell| near.into_iter().filter_map(move |(x, y)| cell.offset(x, y));
        let over = self.seen.cells(&geometry).flat_map(around);
        let over = over.filter(|&cell| geometry.contains(cell)).collect();
        let before = core::mem::replace(&mut self.over, over);
        for &cell in before.difference(&self.over) {
            self.grid.set(cell, self.known.get(cell));
        }
        for &cell in &self.over {
            self.grid.set(cell, Occupancy::Occupied);
        }
    }
}

fn grid(map: &OccupancyGrid) -> Result<Grid, GeometryError> {
    let (info, origin) = (&map.info, Pose2D::from(map.info.origin));
    let origin = (origin.x, origin.y, origin.theta);
    let geometry = Geometry::new(info.width, info.height, info.resolution.into(), origin)?;
    Grid::from_ros(geometry.with_cells(map.data.len())?, &map.data)
}
