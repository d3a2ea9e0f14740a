//! New worlds: a room, or worlds converted from the files of other programs.

use std::fs::{self, File};
use std::io::Write;
use std::path::Path;

use jde_sim::ImportedWorld;

use super::{checked, create_folder, not_created};
use crate::failure::{self, Failure};
use crate::terminal::{self, FAINT, TITLE};

/// The room of the templates.
const ROOM: &str = include_str!("../../templates/room/world.toml");

/// Writes a world as `NAME.toml`, or the worlds of a list into a folder `NAME`, and prints what was left out.
///
/// # Errors
/// The name is invalid, the file to convert has faults, or the worlds cannot be written.
pub(crate) fn write_world(name: &str, from: Option<&Path>, folder: &Path) -> Result<(), Failure> {
    let name = checked(name, |_| false)?.kebab;
    let worlds = match from {
        Some(file) => jde_sim::import(file).map_err(|error| Failure::Broken(error.to_string()))?,
        None => vec![ImportedWorld {
            name: name.clone(),
            text: ROOM.replace("\"room\"", &format!("{name:?}")),
            notes: Vec::new(),
        }],
    };
    let mut out = terminal::out();
    let mut created = folder.join(&name);
    if let [world] = worlds.as_slice() {
        created.set_extension("toml");
        fs::create_dir_all(folder).map_err(Failure::file(folder))?;
        write(&created, &world.text)?;
    } else {
        create_folder(&created)?;
        for world in &worlds {
            write(&created.join(&world.name).with_extension("toml"), &world.text)?;
        }
    }
    for note in worlds.iter().flat_map(|world| &world.notes) {
        writeln!(out, "{FAINT}{note}{FAINT:#}")?;
    }
    let shown = failure::display_path(&created);
    writeln!(out, "{TITLE}{shown}{TITLE:#} is created")?;
    Ok(())
}

/// Writes a new file.
fn write(path: &Path, text: &str) -> Result<(), Failure> {
    File::create_new(path)
        .and_then(|mut file| file.write_all(text.as_bytes()))
        .map_err(|error| not_created(path, error))
}
