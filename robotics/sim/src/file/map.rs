//! ROS occupancy maps: their walls and their place in the world.
//!
//! Occupied cells become solid. Unknown cells do not, but no robot starts on one. A probability is taken for what robots
//! take it for.

use std::path::{Path, PathBuf};

use jde_files::{LeftOut, read_text};
use jde_map_file::{Cell, Kind, MAX_TEXT, MapFile};

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
    /// The path of its YAML file, and what that says for nothing.
    path: PathBuf,
    left_out: LeftOut,
}

/// Reads the map that the world names, if it names one.
pub(crate) fn read(document: &Document<'_>, root: &Table<'_>) -> Option<Option<Map>> {
    let Some(item) = root.get("map") else {
        return Some(None);
    };
    let name = root.required("map", values::text)?;
    let path = document.path().parent().unwrap_or(Path::new("")).join(&name);
    let text = match read_text(&path, MAX_TEXT) {
        Ok(text) => text,
        Err(error) => {
            let shown = path.display();
            let message = match Kind::of_file(&path) {
                Some(kind) => format!("`{shown}` is {kind}, and no ROS map: {}", kind.way_to_map()),
                None => format!("cannot read the map `{shown}`: {error}"),
            };
            root.fault(&item.span(), message);
            return None;
        }
    };
    match load(&name, &path, &text) {
        Ok(None) => {
            let message = format!(
                "the map `{}` has more than {MAX_BLOCKS} separate walls: clean the image of noise",
                path.display(),
            );
            root.fault(&item.span(), message);
            None
        }
        Ok(map) => Some(map),
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

    /// Returns what the file of the map says for nothing.
    pub(crate) fn warnings(&self) -> impl Iterator<Item = Fault> {
        self.left_out.lines().map(|message| Fault {
            file: self.path.clone(),
            line: None,
            message,
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
            Some(Cell::Unknown | Cell::Likely(_)) => Some(format!("on unknown ground of `{}`", self.name)),
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

/// Reads a map; `None` if it has too many walls.
fn load(name: &str, path: &Path, text: &str) -> Result<Option<Map>, Vec<Fault>> {
    let mut file = MapFile::parse(path, text)?;
    file.cells.iter_mut().for_each(|cell| *cell = cell.decided());
    let grid = Grid {
        width: file.width,
        height: file.height,
        cells: file.cells,
    };
    let [x, y, heading] = file.origin;
    Ok(grid.blocks(MAX_BLOCKS).map(|blocks| Map {
        blocks,
        path: path.to_owned(),
        left_out: file.left_out,
        name: name.to_owned(),
        resolution: file.resolution,
        origin: Pose2::new(x, y, heading),
        grid,
    }))
}
