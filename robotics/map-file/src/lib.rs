//! The files of ROS maps: the YAML of a map server and its image, read and written as cells.
//!
//! They mean what they mean to the map server of Nav2. All faults of both files are reported at once, each with its line;
//! nothing is repaired, and what is not read is named.

mod cells;
mod fault;
mod kind;
mod moving_ai;
mod picture;
mod pnm;
mod similar;
#[cfg(test)]
mod tests;
mod write;
mod yaml;

use std::path::Path;

use jde_files::LeftOut;

pub use cells::Cell;
pub use fault::Fault;
pub use kind::Kind;
pub use picture::{Picture, Shade};
pub use similar::nearest;
pub use write::is_yaml;

/// Greatest YAML file of a map, or text of a world, in bytes: enough for thousands of things.
pub const MAX_TEXT: u64 = 4 << 20;

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
    /// The keys of the YAML file that say nothing.
    pub left_out: LeftOut,
}

impl MapFile {
    /// Reads the map of this YAML file, and the image beside it that it names.
    ///
    /// # Errors
    /// All faults of both files.
    pub fn load(path: &Path) -> Result<Self, Vec<Fault>> {
        let fault = |message| {
            vec![Fault {
                file: path.to_owned(),
                line: None,
                message,
            }]
        };
        match jde_files::read_text(path, MAX_TEXT) {
            Ok(text) => Self::parse(path, &text),
            Err(error) => {
                // What is no text may be the image of the map.
                Err(fault(match Kind::of_file(path) {
                    Some(kind) => format!("it is {kind}, and no ROS map: {}", kind.way_to_map()),
                    None => format!("cannot read the map: {error}"),
                }))
            }
        }
    }

    /// Reads the map with this text of the YAML file `path`, and the image that it names.
    ///
    /// # Errors
    /// All faults of both files.
    pub fn parse(path: &Path, text: &str) -> Result<Self, Vec<Fault>> {
        let (info, mut faults) = match yaml::read(path, text) {
            Ok(info) => (Some(info), Vec::new()),
            Err(faults) => (None, faults),
        };
        let image = match &info {
            Some(info) => Some(info.image.clone()),
            None => yaml::image(path, text),
        };
        let picture = image.map(|image| Picture::load(&image, Shade::Luminance));
        let picture = picture.and_then(|picture| {
            picture
                .map_err(|mut fault| {
                    fault.message += &elsewhere(path, &fault.file);
                    faults.push(fault);
                })
                .ok()
        });
        let (Some(info), Some(picture)) = (info, picture) else {
            return Err(faults);
        };
        Ok(Self {
            width: picture.width,
            height: picture.height,
            resolution: info.resolution,
            origin: info.origin,
            cells: cells::classify(&picture, info.mode, info.thresholds),
            left_out: info.left_out,
        })
    }
}

/// Returns where the image of a map may be that is not where the YAML file says, as after a copy from another computer.
fn elsewhere(yaml: &Path, image: &Path) -> String {
    let name = image.file_name().unwrap_or_default();
    let beside = yaml.with_file_name(name);
    match !image.exists() && beside.is_file() {
        true => format!("; `image: {}` is the one beside the YAML file", name.display()),
        false => String::new(),
    }
}
