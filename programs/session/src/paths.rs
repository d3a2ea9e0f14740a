//! Finds applications, experiments and worlds by name: in the working directory, then among the data of this
//! program.

use std::path::{Path, PathBuf};

use crate::failure::{Failure, list};

/// The folder of this program's data: `share/jde` of its installation, or else the checkout that it was built
/// from, which may no longer exist. Both hold `apps`, `experiments`, `worlds` and the crates of the SDK.
pub fn data() -> PathBuf {
    let installed = std::env::current_exe()
        .ok()
        .and_then(|exe| Some(exe.parent()?.parent()?.join("share/jde")));
    installed
        .filter(|folder| folder.is_dir())
        .unwrap_or_else(checkout)
}

/// The checkout that this program was built from.
fn checkout() -> PathBuf {
    let mut above = Path::new(env!("CARGO_MANIFEST_DIR")).ancestors();
    above.nth(2).unwrap_or(Path::new("/")).to_owned()
}

/// Returns the file of an application, given as a file or by name.
///
/// # Errors
/// There is no application of this name. The error lists the known names.
pub fn find_application(given: &Path) -> Result<PathBuf, Failure> {
    find(given, "apps", "application")
}

/// Returns the file of an experiment, given as a file or by name.
///
/// # Errors
/// There is no experiment of this name. The error lists the known names.
pub fn find_experiment(given: &Path) -> Result<PathBuf, Failure> {
    find(given, "experiments", "experiment")
}

/// Returns the file of a world, given as a file or by name.
///
/// # Errors
/// There is no world of this name. The error lists the known names.
pub fn find_world(given: &Path) -> Result<PathBuf, Failure> {
    find(given, "worlds", "world")
}

/// Returns a given file, or finds it by name in a folder of one of the homes.
fn find(given: &Path, folder: &str, what: &str) -> Result<PathBuf, Failure> {
    let text = given.to_string_lossy();
    let is_a_name = !text.contains('/') && !text.ends_with(".toml");
    if given.is_file() {
        return Ok(given.to_owned());
    }
    let homes = [PathBuf::new(), data()];
    if !is_a_name {
        let shipped = data().join(given);
        return match given.file_stem() {
            Some(name) if given.starts_with(folder) && shipped.is_file() => Err(Failure::usage(
                format!("{}: there is no such file", given.display()),
                format!(
                    "did you mean `{}`, the {what} that comes with `jde`?",
                    name.display()
                ),
            )),
            // A misspelt path gets the nearest file of its folder where it is read.
            _ if given.exists() || text.contains('/') || has_similar(given) => Ok(given.to_owned()),
            _ => Err(unknown(
                format!("{text}: there is no such file"),
                &given.file_stem().unwrap_or_default().to_string_lossy(),
                &list_names(&homes, folder),
            )),
        };
    }
    let found = homes
        .iter()
        .map(|home| home.join(format!("{folder}/{text}.toml")))
        .find(|file| file.is_file());
    // Whoever reads what else is there says what it is.
    let other = || given.exists().then(|| given.to_owned());
    found.or_else(other).ok_or_else(|| {
        unknown(
            format!("there is no {what} `{text}`"),
            &text,
            &list_names(&homes, folder),
        )
    })
}

/// Whether the working directory has a file of a similar name, of the same kind.
fn has_similar(given: &Path) -> bool {
    let names = list_names(&[PathBuf::new()], ".");
    let name = given.file_stem().unwrap_or_default().to_string_lossy();
    jde_nearest::nearest(&name, names.iter().map(String::as_str)).is_some()
}

/// Returns wrong use because of an unknown name, with the nearest of the known names, or all of them.
fn unknown(message: String, name: &str, names: &[String]) -> Failure {
    let help = match jde_nearest::nearest(name, names.iter().map(String::as_str)) {
        Some(near) => format!("did you mean `{near}`?"),
        None if names.is_empty() => "give the path of its file".to_owned(),
        None => {
            let names = list(names.iter().map(String::as_str));
            format!("give the path of its file, or one of: {names}")
        }
    };
    Failure::usage(message, help)
}

/// The names of all files in a folder of the homes.
fn list_names(homes: &[PathBuf], folder: &str) -> Vec<String> {
    let mut names: Vec<String> = homes
        .iter()
        .filter_map(|home| std::fs::read_dir(home.join(folder)).ok())
        .flatten()
        .filter_map(|entry| {
            entry
                .ok()?
                .file_name()
                .to_str()?
                .strip_suffix(".toml")
                .map(str::to_owned)
        })
        .collect();
    names.sort();
    names.dedup();
    names
}
