//! ROS occupancy maps: their walls and their place in the world.
//!
//! Occupied cells become solid. Unknown cells do not, but no robot starts on one. A probability is taken for what robots
//! take it for.

use std::path::{Path, PathBuf};

use jde_files::LeftOut;
use jde_map_file::{MapCell, MapFile};

use super::fixtures;
use super::grid::{Block, Grid};
use super::values;
use crate::geometry::Pose2;
use crate::scene::Fixture;
use crate::shape::Outline;
use jde_document::{Fault, FaultReport, Section};

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
pub(crate) fn read(report: &mut FaultReport<'_>, root: &Section<'_>) -> Option<Option<Map>> {
    let Some(node) = root.get("map") else {
        return Some(None);
    };
    let name = root.required(report, "map", values::text)?;
    let path = report.file().parent().unwrap_or(Path::new("")).join(&name);
    let mut file = MapFile::load(&path)
        .map_err(|faults| match faults.list() {
            // Of a file that is no map, the place that names it is wrong.
            [fault] if fault.line().is_none() && fault.location.file() == Some(&path) => {
                let message = format!("`map` of the world: {}: {}", path.display(), fault.message);
                report.fault(&node.span(), message).help = fault.help.clone();
            }
            _ => report.include(faults),
        })
        .ok()?;
    file.cells.iter_mut().for_each(|cell| *cell = cell.decided());
    let grid = Grid {
        width: file.width,
        height: file.height,
        cells: file.cells,
    };
    let Some(blocks) = grid.blocks(MAX_BLOCKS) else {
        let message = format!(
            "the map `{}` has more than {MAX_BLOCKS} separate walls: clean the image of noise",
            path.display(),
        );
        report.fault(&node.span(), message);
        return None;
    };
    let [x, y, heading] = file.origin;
    Some(Some(Map {
        blocks,
        path,
        left_out: file.left_out,
        name,
        resolution: file.resolution,
        origin: Pose2::new(x, y, heading),
        grid,
    }))
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
        self.left_out
            .lines()
            .map(|message| Fault::of_file(&self.path, message))
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
            Some(MapCell::Free) => None,
            Some(MapCell::Occupied) => Some(format!("inside `{}`: move it to free ground", self.name)),
            Some(MapCell::Unknown | MapCell::Likely(_)) => {
                Some(format!("on unknown ground of `{}`", self.name))
            }
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
