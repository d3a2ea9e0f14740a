//! New worlds: a room, or worlds converted from the files of other programs.

use std::io::{ErrorKind, Write};
use std::path::{Path, PathBuf};

use jde_sim::ImportedWorld;
use jde_terminal::{self as terminal, FAINT, TITLE};

use super::{checked, create_folder, not_created, write_file};
use crate::failure::{self, Failure};

/// Where Gazebo searches for models: lists of folders, of its present and earlier versions.
const MODEL_PATHS: [&str; 4] = [
    "GZ_SIM_RESOURCE_PATH",
    "IGN_GAZEBO_RESOURCE_PATH",
    "SDF_PATH",
    "GAZEBO_MODEL_PATH",
];
/// The room of the templates.
const ROOM: &str = include_str!("../../templates/room/world.toml");

/// Writes a world as `NAME.toml` with the files that it names, or the worlds of a list into a folder `NAME`, and
/// prints what was left out. The models of SDF worlds are searched in the folders `models`, and then where Gazebo searches.
///
/// # Errors
/// The name is invalid, the file to convert has faults, or the worlds cannot be written.
pub(crate) fn write_world(
    name: &str,
    from: Option<&Path>,
    models: &[PathBuf],
    folder: &Path,
) -> Result<(), Failure> {
    let name = checked(name, |_| false)?.kebab;
    let worlds = match from {
        Some(file) => {
            let worlds = jde_sim::import(file, &searched(models), &name);
            worlds.map_err(|error| Failure::broken(error.to_string()))?
        }
        None => vec![ImportedWorld {
            name: name.clone(),
            text: ROOM.replace("\"room\"", &format!("{name:?}")),
            files: Vec::new(),
            left_out: Default::default(),
            notes: Vec::new(),
        }],
    };
    let mut out = terminal::out();
    let mut created = folder.join(&name);
    if let [world] = worlds.as_slice() {
        created.set_extension("toml");
        jde_files::create_folder(folder).map_err(Failure::file(folder))?;
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
    for line in worlds.iter().flat_map(ImportedWorld::report) {
        writeln!(out, "{FAINT}{line}{FAINT:#}")?;
    }
    let shown = failure::display_path(&created);
    writeln!(out, "{TITLE}{shown}{TITLE:#} is created")?;
    Ok(())
}

/// Returns the folders in which models are searched, in their order.
fn searched(models: &[PathBuf]) -> Vec<PathBuf> {
    let lists = MODEL_PATHS.into_iter().filter_map(std::env::var_os);
    let stated: Vec<_> = lists
        .flat_map(|list| std::env::split_paths(&list).collect::<Vec<_>>())
        .collect();
    let named = stated.into_iter().filter(|folder| !folder.as_os_str().is_empty());
    models.iter().cloned().chain(named).collect()
}
