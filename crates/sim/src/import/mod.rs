//! Converts worlds of other programs into world files. What has no counterpart in a world is left out, and a
//! note says so.
//!
//! It converts once and reads no world while a robot drives.

mod cylinders;
mod pose;
mod sdf;
mod worldfile;
mod writer;

use std::path::{Path, PathBuf};

use jde_files::LeftOut;

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
    /// What the file has and the world has not.
    pub left_out: LeftOut,
    /// What the world has in another form than the file, and advice, in sentences.
    pub notes: Vec<String>,
}

impl ImportedWorld {
    /// Returns what a user is told of the conversion, a line each.
    pub fn report(&self) -> impl Iterator<Item = String> {
        self.notes.iter().cloned().chain(self.left_out.lines())
    }
}

/// Converts the worlds of a file: one of an SDF file or of a world file of Stage, or all of a list in the form
/// of the BARN challenge, in which a line has the number of a world and the centres `x,y` of its cylinders, m.
/// `models` are folders in which the models of SDF worlds are searched.
///
/// # Errors
/// A file that cannot be read, is of no such kind or has faults, each with its line.
pub fn import(path: &Path, models: &[PathBuf]) -> Result<Vec<ImportedWorld>, WorldError> {
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
