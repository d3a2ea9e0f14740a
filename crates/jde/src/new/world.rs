//! New worlds: a room, or worlds converted from the files of other programs.

use std::fs;
use std::io::{ErrorKind, Write};
use std::path::Path;

use jde_sim::ImportedWorld;

use super::{checked, create_folder, not_created, write_file};
use crate::failure::{self, Failure};
use crate::terminal::{self, FAINT, TITLE};

/// The room of the templates.
const ROOM: &str = include_str!("../../templates/room/world.toml");

/// Writes a world as `NAME.toml` with the files that it names, or the worlds of a list into a folder `NAME`, and
/// prints what was left out.
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
            files: Vec::new(),
            notes: Vec::new(),
        }],
    };
    let mut out = terminal::out();
    let mut created = folder.join(&name);
    if let [world] = worlds.as_slice() {
        created.set_extension("toml");
        fs::create_dir_all(folder).map_err(Failure::file(folder))?;
        let files = world
            .files
            .iter()
            .map(|(name, contents)| (folder.join(name), &contents[..]));
        let files: Vec<_> = files.chain([(created.clone(), world.text.as_bytes())]).collect();
        // All or none.
        if let Some((taken, _)) = files.iter().find(|(file, _)| file.exists()) {
            return Err(not_created(taken, ErrorKind::AlreadyExists.into()));
        }
        for (file, contents) in files {
            write_file(&file, contents)?;
        }
    } else {
        create_folder(&created)?;
        for world in &worlds {
            write_file(&created.join(&world.name).with_extension("toml"), &world.text)?;
        }
    }
    for note in worlds.iter().flat_map(|world| &world.notes) {
        writeln!(out, "{FAINT}{note}{FAINT:#}")?;
    }
    let shown = failure::display_path(&created);
    writeln!(out, "{TITLE}{shown}{TITLE:#} is created")?;
    Ok(())
}
