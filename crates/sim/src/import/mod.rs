//! Converts worlds of other programs into world files. What has no counterpart in a world is left out, and a
//! note says so.
//!
//! It converts once and reads no world while a robot drives.

mod cylinders;
mod pose;
mod sdf;
mod worldfile;
mod writer;

use std::path::Path;

use crate::error::{Fault, WorldError};
use crate::file;

/// A thing whose lower edge is higher is above every robot, m.
const OVERHEAD: f64 = 0.5;

/// A converted world.
#[derive(Clone, Debug, PartialEq)]
pub struct ImportedWorld {
    /// Its name: the number of a world in a list, else the stem of the file's name.
    pub name: String,
    /// The text of its world file.
    pub text: String,
    /// Files that it names, to be written beside it: name and contents.
    pub files: Vec<(String, Vec<u8>)>,
    /// What was left out or changed, in sentences.
    pub notes: Vec<String>,
}

/// Converts the worlds of a file: one of an SDF file or of a world file of Stage, or all of a list in the form
/// of the BARN challenge, in which a line has the number of a world and the centres `x,y` of its cylinders, m.
///
/// # Errors
/// A file that cannot be read, is of no such kind or has faults, each with its line.
pub fn import(path: &Path) -> Result<Vec<ImportedWorld>, WorldError> {
    let text = file::load(path, "file")?;
    let stem = path
        .file_stem()
        .unwrap_or_default()
        .to_string_lossy()
        .into_owned();
    // World files of Stage begin with a word or a comment, and lists with a number.
    let first = text.trim_start().chars().next();
    let read = match first {
        Some('<') => sdf::read(&text, stem).map(|world| vec![world]),
        Some('#' | 'a'..='z' | 'A'..='Z') => {
            let read = worldfile::read(path, &text, stem).map(|world| vec![world]);
            return read.map_err(WorldError::Faults);
        }
        _ => cylinders::read(&text, &stem),
    };
    read.map_err(|faults| {
        let faults = faults.into_iter().map(|(line, message)| Fault {
            file: path.to_owned(),
            line: Some(line),
            message,
        });
        WorldError::Faults(faults.collect())
    })
}

/// Faults with their lines.
type Faults = Vec<(usize, String)>;
