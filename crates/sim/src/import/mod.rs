//! Converts worlds of other programs into world files. What has no counterpart in a world is left out, and a
//! note says so.
//!
//! It converts once and reads no world while a robot drives.

mod cylinders;
mod sdf;
mod writer;

use std::path::Path;

use crate::error::{Fault, WorldError};
use crate::file;

/// A converted world.
#[derive(Clone, Debug, PartialEq)]
pub struct ImportedWorld {
    /// Its name: the number of a world in a list, else the stem of the file's name.
    pub name: String,
    /// The text of its world file.
    pub text: String,
    /// What was left out or changed, in sentences.
    pub notes: Vec<String>,
}

/// Converts the worlds of a file: one of an SDF file, or all of a list in the form of the BARN challenge, in
/// which a line has the number of a world and the centres `x,y` of its cylinders, m.
///
/// # Errors
/// A file that cannot be read, is of neither kind or has faults, each with its line.
pub fn import(path: &Path) -> Result<Vec<ImportedWorld>, WorldError> {
    let text = file::load(path, "file")?;
    let stem = path
        .file_stem()
        .unwrap_or_default()
        .to_string_lossy()
        .into_owned();
    let read = if text.trim_start().starts_with('<') {
        sdf::read(&text, stem).map(|world| vec![world])
    } else {
        cylinders::read(&text, &stem)
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
