//! Converts worlds of other programs into world files. What has no counterpart in a world is left out, and a
//! report says so. A file is recognized by its content, and one that cannot be converted is named as what it is.
//!
//! It converts once and reads no world while a robot drives.

mod cylinders;
mod map;
mod pose;
mod sdf;
mod worldfile;
mod writer;

use std::path::{Path, PathBuf};

use jde_document::{Fault, Faults};
use jde_files::LeftOut;
use jde_map_file::{Kind, MapFile};

use crate::error::WorldError;
use crate::file;

/// Greatest file that is read, bytes.
const MAX_TEXT: u64 = 32 << 20;
/// Greatest world file that can be read again, bytes.
const MAX_WORLD: usize = 4 << 20;
/// A thing whose lower edge is higher is above every robot, m.
const OVERHEAD: f64 = 0.5;

/// A converted world.
#[derive(Clone, Debug, PartialEq)]
pub struct ImportedWorld {
    /// Its name: the number of a world in a list, else the one that it is given.
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
        // Names are those of the file, whatever letters they have.
        let lines = self.notes.iter().cloned().chain(self.left_out.lines());
        lines.map(|line| line.replace(char::is_control, " "))
    }
}

/// Converts the worlds of a file, which may be packed with gzip: one of an SDF file, a world file of Stage, the YAML file
/// of a ROS map or a map of MovingAI, or all of a list in the form of the BARN challenge, in which a line has the number
/// of a world and the centres `x,y` of its cylinders, m. `models` are folders in which the models of SDF worlds are
/// searched. `name` is that of the world, unless the file is a list; its files have names that begin with it.
///
/// # Errors
/// A file that cannot be read, is of no such kind or has faults, each with its line.
pub fn import(path: &Path, models: &[PathBuf], name: &str) -> Result<Vec<ImportedWorld>, WorldError> {
    let fault = |message| Faults::from(Fault::of_file(path, message));
    let other = |kind| fault(file::other_kind(kind, path, "world"));
    let bytes = jde_files::read_unpacked(path, MAX_TEXT).map_err(|error| match Kind::of_file(path) {
        _ if path.is_dir() => fault(in_folder(path)),
        Some(kind) if !kind.becomes_world() => other(kind),
        Some(_) | None => fault(format!("cannot read the file: {error}")),
    })?;
    let (kind, is_binary) = (Kind::of(&bytes), bytes.contains(&0));
    let text = decoded(bytes);
    let (one, name) = (|world| vec![world], name.to_owned());
    let starts_with_digit = text
        .trim_start()
        .starts_with(|first: char| first.is_ascii_digit());
    let worlds = match kind {
        Some(Kind::Sdf | Kind::Xml) => sdf::read(path, &text, name, models).map(one),
        Some(Kind::RosMap) => {
            MapFile::parse(path, &text).map(|map| one(map::world(map, "A ROS map. Metres, degrees.", &name)))
        }
        Some(Kind::MovingAi) => MapFile::parse_moving_ai(path, &text)
            .map(|map| one(map::moving_ai(map, &name)))
            .map_err(Faults::from),
        Some(Kind::Cylinders) | None if kind.is_some() || starts_with_digit => cylinders::read(path, &text),
        None if is_binary => Err(fault("it is a binary file of an unknown kind".to_owned())),
        // A world of Stage may begin with settings that are no sign of it.
        Some(Kind::Stage) | None => worldfile::read(path, &text, name).map(one),
        Some(kind) => Err(other(kind)),
    };
    let worlds = worlds?;
    match worlds.iter().find(|world| world.text.len() > MAX_WORLD) {
        None => Ok(worlds),
        Some(world) => Err(fault(format!(
            "its world would have {} MiB, and a world has at most {}: convert a part of it",
            world.text.len().div_ceil(1 << 20),
            MAX_WORLD >> 20
        ))
        .into()),
    }
}

/// Returns a text in UTF-8 or Latin-1, without the byte order mark.
fn decoded(bytes: Vec<u8>) -> String {
    let latin_1 = |bytes: Vec<u8>| bytes.into_iter().map(char::from).collect();
    let text = String::from_utf8(bytes).unwrap_or_else(|error| latin_1(error.into_bytes()));
    match text.strip_prefix('\u{feff}') {
        Some(rest) => rest.to_owned(),
        None => text,
    }
}

/// Returns what to do with a folder.
fn in_folder(path: &Path) -> String {
    /// Most files that are named.
    const MAX_NAMED: usize = 5;
    const EXTENSIONS: [&str; 6] = ["world", "sdf", "yaml", "yml", "map", "txt"];
    let entries = std::fs::read_dir(path).into_iter().flatten().flatten();
    let mut files: Vec<_> = entries
        .map(|entry| entry.path())
        .filter(|file| {
            let extension = file.extension().and_then(|extension| extension.to_str());
            extension.is_some_and(|extension| EXTENSIONS.contains(&extension))
        })
        .map(|file| format!("`{}`", file.display()))
        .collect();
    files.sort();
    files.truncate(MAX_NAMED);
    match files.as_slice() {
        [] => "it is a folder: give a world in it".to_owned(),
        files => format!("it is a folder: give a file in it, such as {}", files.join(", ")),
    }
}

/// Returns the names of the files of the map of a world: the YAML file and its image.
fn map_files(name: &str) -> (String, String) {
    (format!("{name}-map.yaml"), format!("{name}-map.pgm"))
}
