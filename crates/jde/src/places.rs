//! Where applications and worlds are found by name: here, in the checkout this program was built from, or installed.

use std::path::{Path, PathBuf};

use crate::failure::Failure;

/// The checkout this program was built from; it may be gone.
pub(crate) fn checkout() -> PathBuf {
    let mut above = Path::new(env!("CARGO_MANIFEST_DIR")).ancestors();
    above.nth(2).unwrap_or(Path::new("/")).to_owned()
}

/// Folders that hold `apps` and `worlds`, the nearest first.
fn homes() -> Vec<PathBuf> {
    let mut homes = vec![PathBuf::new(), checkout()];
    if let Some(prefix) = std::env::current_exe()
        .ok()
        .and_then(|exe| Some(exe.parent()?.parent()?.to_owned()))
    {
        homes.push(prefix.join("share/jde"));
    }
    homes
}

/// The file of an application that is given as a file or by name.
///
/// # Errors
/// No such file and no such name; the names there are.
pub(crate) fn application(given: &Path) -> Result<PathBuf, Failure> {
    find(given, "apps", "application")
}

/// The file of a world that is given as a file or by name.
///
/// # Errors
/// No such file and no such name; the names there are.
pub(crate) fn world(given: &Path) -> Result<PathBuf, Failure> {
    find(given, "worlds", "world")
}

/// A file that is given as such, or by its name in a folder of one of the homes.
fn find(given: &Path, folder: &str, what: &str) -> Result<PathBuf, Failure> {
    let text = given.to_string_lossy();
    let is_a_name = !text.contains('/') && !text.ends_with(".toml");
    if !is_a_name || given.is_file() {
        return Ok(given.to_owned());
    }
    let homes = homes();
    let found = homes
        .iter()
        .map(|home| home.join(format!("{folder}/{text}.toml")))
        .find(|file| file.is_file());
    found.ok_or_else(|| {
        let names = names(&homes, folder);
        let near = names
            .iter()
            .map(|name| (strsim::damerau_levenshtein(name, &text), name))
            .filter(|(distance, name)| *distance <= (name.len() / 3).max(1))
            .min();
        let help = match near {
            Some((_, near)) => format!("did you mean `{near}`?"),
            None if names.is_empty() => "give the path of its file".to_owned(),
            None => format!("give the path of its file, or one of: {}", names.join(", ")),
        };
        Failure::usage(format!("there is no {what} `{text}`"), help)
    })
}

/// Names of all files there are in a folder of the homes.
fn names(homes: &[PathBuf], folder: &str) -> Vec<String> {
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
