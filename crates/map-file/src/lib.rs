//! The files of ROS maps: the YAML of a map server and its image, read and written as cells.
//!
//! Trinary maps only. All faults of both files are reported at once, each with its line; nothing is repaired.

mod bytes;
mod fault;
mod pgm;
mod picture;
mod similar;
mod write;
mod yaml;

use std::path::Path;

pub use bytes::read_text;
pub use fault::Fault;
pub use similar::nearest;
pub use write::is_yaml;

use picture::Picture;
use yaml::MapInfo;

/// The content of a cell of a map.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cell {
    /// Nothing stands there.
    Free,
    /// Something stands there.
    Occupied,
    /// The map does not say.
    Unknown,
}

/// A map as its files state it.
#[derive(Clone, Debug, PartialEq)]
pub struct MapFile {
    /// Columns.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// The length of a cell's side in metres.
    pub resolution: f64,
    /// The lower left corner in the world: x, y in metres and the heading in radians.
    pub origin: [f64; 3],
    /// The cells by rows, from the lowest row.
    pub cells: Vec<Cell>,
}

impl MapFile {
    /// Reads the map of this YAML file, and the image beside it that it names.
    ///
    /// # Errors
    /// All faults of both files.
    pub fn load(path: &Path) -> Result<Self, Vec<Fault>> {
        let text = read_text(path).map_err(|error| {
            vec![Fault {
                file: path.to_owned(),
                line: None,
                message: format!("cannot read the map: {error}"),
            }]
        })?;
        Self::parse(path, &text)
    }

    /// Reads the map with this text of the YAML file `path`, and the image that it names.
    ///
    /// # Errors
    /// All faults of both files.
    pub fn parse(path: &Path, text: &str) -> Result<Self, Vec<Fault>> {
        let info = yaml::read(path, text)?;
        Ok(Self {
            width: info.picture.width,
            height: info.picture.height,
            resolution: info.resolution,
            origin: info.origin,
            cells: classify(&info),
        })
    }
}

/// Classifies the shades: a darker cell is more likely occupied. `negate` inverts that.
fn classify(info: &MapInfo) -> Vec<Cell> {
    let cell = |&shade: &f32| {
        let likely = f64::from(if info.negate { shade } else { 1.0 - shade });
        if likely > info.occupied {
            Cell::Occupied
        } else if likely < info.free {
            Cell::Free
        } else {
            Cell::Unknown
        }
    };
    let Picture { width, shades, .. } = &info.picture;
    shades.chunks_exact(*width).rev().flatten().map(cell).collect()
}
