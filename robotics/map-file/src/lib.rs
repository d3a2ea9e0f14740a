//! The files of ROS maps: the YAML of a map server and its image, read and written as cells.
//!
//! They mean what they mean to the map server of Nav2. All faults of both files are reported at once, each with its line;
//! nothing is repaired, and what is not read is named.

mod cells;
mod kind;
mod moving_ai;
mod picture;
mod pnm;
#[cfg(test)]
mod tests;
mod write;
mod yaml;

use std::path::Path;

use jde_document::{Fault, FaultReport, Faults};
use jde_files::LeftOut;

pub use cells::MapCell;
pub use kind::Kind;
pub use picture::{Picture, Shade};
pub use write::is_yaml;

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
    pub cells: Vec<MapCell>,
    /// The keys of the YAML file that say nothing.
    pub left_out: LeftOut,
}

impl MapFile {
    /// Reads the map of this YAML file, and the image beside it that it names.
    ///
    /// # Errors
    /// All faults of both files.
    pub fn load(path: &Path) -> Result<Self, Faults> {
        let text = jde_document::read(path, "the YAML file of a map").map_err(|faults| {
            // What is no text may be the image of the map.
            match Kind::of_file(path) {
                Some(kind) => Fault::of_file(
                    path,
                    format!("it is {kind}, and no ROS map: {}", kind.way_to_map()),
                )
                .into(),
                None => faults,
            }
        })?;
        Self::parse(path, &text)
    }

    /// Reads the map with this text of the YAML file `path`, and the image that it names.
    ///
    /// # Errors
    /// All faults of both files.
    pub fn parse(path: &Path, text: &str) -> Result<Self, Faults> {
        let mut report = FaultReport::new(path, text);
        let (image, info) = yaml::read(&mut report, text);
        let picture = image.and_then(|image| {
            let picture = Picture::load(&image, Shade::Luminance);
            let advise = |mut fault: Fault| {
                fault.help = elsewhere(path, &image);
                report.include(fault.into());
            };
            picture.map_err(advise).ok()
        });
        let (Some(info), Some(picture), 0) = (info, picture, report.count()) else {
            return Err(report.into_faults());
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
fn elsewhere(yaml: &Path, image: &Path) -> Option<String> {
    let name = image.file_name()?;
    let is_beside = !image.exists() && yaml.with_file_name(name).is_file();
    is_beside.then(|| format!("`image: {}` is the one beside the YAML file", name.display()))
}
