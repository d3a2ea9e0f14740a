//! ROS occupancy maps: their walls and their place in the world.
//!
//! Occupied cells become solid. Unknown cells do not, but no robot starts on one.

use std::path::Path;

use jde_map_file::{Cell, MapFile, read_text};

use super::document::{Document, Table};
use super::fixtures;
use super::grid::{Block, Grid};
use super::values;
use crate::error::Fault;
use crate::geometry::Pose2;
use crate::scene::Fixture;
use crate::shape::Outline;

/// Most rectangles of occupied cells: a hundred times those of a large building, and as many as the tree of
/// shapes builds in a second.
const MAX_BLOCKS: usize = 500_000;

pub(crate) struct Map {
    name: String,
    /// The length of a cell's side in metres.
    resolution: f64,
    /// The lower left corner of the image in the world.
    origin: Pose2,
    grid: Grid,
    /// The rectangles that cover its occupied cells.
    blocks: Vec<Block>,
}

/// Reads the map that the world names, if it names one.
pub(crate) fn read(document: &Document<'_>, root: &Table<'_>) -> Option<Option<Map>> {
    let Some(item) = root.get("map") else {
        return Some(None);
    };
    let name = root.required("map", values::text)?;
    let path = document.path().parent().unwrap_or(Path::new("")).join(&name);
    let text = match read_text(&path) {
        Ok(text) => text,
        Err(error) => {
            root.fault(
                &item.span(),
                format!("cannot read the map `{}`: {error}", path.display()),
            );
            return None;
        }
    };
    match load(&name, &path, &text) {
        Ok(map) if map.blocks.len() > MAX_BLOCKS => {
            let message = format!(
                "the map `{}` has {} separate walls, and at most {MAX_BLOCKS} are possible: clean the image of noise",
                path.display(),
                map.blocks.len()
            );
            root.fault(&item.span(), message);
            None
        }
        Ok(map) => Some(Some(map)),
        Err(faults) => {
            faults.into_iter().for_each(|fault| document.push(fault));
            None
        }
    }
}

impl Map {
    pub(crate) fn fixtures(&self) -> impl Iterator<Item = Fixture> {
        self.blocks.iter().map(|block| {
            let (left, right) = (block.left as f64, block.right as f64);
            let (bottom, top) = (block.bottom as f64, block.top as f64);
            let outline = Outline::Box {
                center: self.at((left + right) / 2.0, (bottom + top) / 2.0),
                size: [(right - left) * self.resolution, (top - bottom) * self.resolution],
                angle: self.origin.heading,
            };
            fixtures::fixture(self.name.clone(), outline, fixtures::WALL)
        })
    }

    /// Returns the four corners of the image in the world.
    pub(crate) fn corners(&self) -> [[f64; 2]; 4] {
        let (width, height) = (self.grid.width as f64, self.grid.height as f64);
        [
            self.at(0.0, 0.0),
            self.at(width, 0.0),
            self.at(0.0, height),
            self.at(width, height),
        ]
    }

    /// Returns why a robot cannot start at a point of the world; `None` if the map allows it.
    pub(crate) fn misplaced(&self, [x, y]: [f64; 2]) -> Option<String> {
        let (sin, cos) = libm::sincos(self.origin.heading);
        let (dx, dy) = (x - self.origin.x, y - self.origin.y);
        let (column, row) = (
            (cos * dx + sin * dy) / self.resolution,
            (cos * dy - sin * dx) / self.resolution,
        );
        let inside =
            (0.0..self.grid.width as f64).contains(&column) && (0.0..self.grid.height as f64).contains(&row);
        let cell = inside.then(|| self.grid.cells[row as usize * self.grid.width + column as usize]);
        match cell {
            Some(Cell::Free) => None,
            Some(Cell::Occupied) => Some(format!("inside `{}`: move it to free ground", self.name)),
            Some(Cell::Unknown) => Some(format!("on unknown ground of `{}`", self.name)),
            None => Some(format!("outside the map `{}`", self.name)),
        }
    }

    /// Returns the point of the world at a column and a row.
    fn at(&self, column: f64, row: f64) -> [f64; 2] {
        let point = self
            .origin
            .compose(Pose2::new(column * self.resolution, row * self.resolution, 0.0));
        [point.x, point.y]
    }
}

fn load(name: &str, path: &Path, text: &str) -> Result<Map, Vec<Fault>> {
    let file = MapFile::parse(path, text)?;
    let grid = Grid {
        width: file.width,
        height: file.height,
        cells: file.cells,
    };
    let [x, y, heading] = file.origin;
    Ok(Map {
        blocks: grid.blocks(),
        name: name.to_owned(),
        resolution: file.resolution,
        origin: Pose2::new(x, y, heading),
        grid,
    })
}
