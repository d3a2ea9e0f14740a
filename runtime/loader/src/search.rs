//! The folders in which plugins are searched for, and their order. It loads nothing.

use std::collections::{BTreeMap, HashSet};
use std::path::{Path, PathBuf};

use jde_abi::raw;

use super::{elf, python};

/// Folders in which plugins are searched for; the first that contains a plugin wins.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct SearchPath {
    folders: Vec<(PathBuf, &'static str)>,
}

/// A file that looks like a plugin.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PluginFile {
    /// The plugin's name, derived from the file name.
    pub name: String,
    /// The file.
    pub path: PathBuf,
    /// Why this folder is searched: "beside the application", "JDE_PLUGIN_PATH", ...
    pub reason: &'static str,
}

impl SearchPath {
    /// The reason for searching the executable's own folder.
    pub const BESIDE_THE_EXECUTABLE: &str = "beside the executable";

    /// Returns the usual folders in order: beside the application (its folder, and `plugins` in it),
    /// `JDE_PLUGIN_PATH`, beside the executable (where a build of the workspace puts them), and the installed
    /// folders (`lib/jde` next to the executable's folder, then `~/.local/lib/jde`).
    #[must_use]
    pub fn usual(application: Option<&Path>) -> Self {
        let mut path = Self::default();
        if let Some(folder) = application.and_then(Path::parent) {
            let folder = if folder.as_os_str().is_empty() {
                Path::new(".")
            } else {
                folder
            };
            path.push(folder, "beside the application");
            path.push(folder.join("plugins"), "beside the application");
        }
        if let Some(listed) = std::env::var_os("JDE_PLUGIN_PATH") {
            for folder in std::env::split_paths(&listed).filter(|folder| !folder.as_os_str().is_empty()) {
                path.push(folder, "JDE_PLUGIN_PATH");
            }
        }
        if let Ok(executable) = std::env::current_exe() {
            path.push_executable(&executable);
        }
        if let Some(home) = std::env::home_dir() {
            path.push(home.join(".local/lib/jde"), "installed");
        }
        path
    }

    /// Where plugins are searched for that no folder contains, and the reason.
    pub const ENTRY_POINTS: (&str, &str) = ("jde.schemas", "entry points of Python");

    /// Appends the folder of an executable, and the installed folder that belongs to it.
    pub fn push_executable(&mut self, executable: &Path) {
        if let Some(folder) = executable.parent() {
            self.push(folder, Self::BESIDE_THE_EXECUTABLE);
            if let Some(prefix) = folder.parent() {
                self.push(prefix.join("lib/jde"), "installed");
            }
        }
    }

    /// Appends a folder; a folder that is already listed keeps its position.
    pub fn push(&mut self, folder: impl Into<PathBuf>, reason: &'static str) {
        let folder = folder.into();
        if !self.folders.iter().any(|(known, _)| *known == folder) {
            self.folders.push((folder, reason));
        }
    }

    /// Returns the path that searches these folders first.
    pub(crate) fn after(&self, first: &[PathBuf], reason: &'static str) -> Self {
        let first = first.iter().map(|folder| (folder, reason));
        let rest = self.folders.iter().map(|(folder, reason)| (folder, *reason));
        let mut known = HashSet::new();
        let all = first.chain(rest).filter(|(folder, _)| known.insert(*folder));
        Self {
            folders: all.map(|(folder, reason)| (folder.clone(), reason)).collect(),
        }
    }

    /// Returns the folders, each with the reason for searching it.
    pub fn folders(&self) -> impl Iterator<Item = (&Path, &'static str)> {
        self.folders
            .iter()
            .map(|(folder, reason)| (folder.as_path(), *reason))
    }

    /// Returns the file of a plugin by the plugin's name, if a folder contains it.
    #[must_use]
    pub fn find(&self, name: &str) -> Option<PluginFile> {
        let file = file_name(name);
        self.folders.iter().find_map(|(folder, reason)| {
            let path = folder.join(&file);
            path.exists().then(|| PluginFile {
                name: name.to_owned(),
                path,
                reason,
            })
        })
    }

    /// Returns all files that look like plugins, by name; of several with one name, the one that would be
    /// loaded.
    #[must_use]
    pub fn list(&self) -> Vec<PluginFile> {
        let mut found = BTreeMap::new();
        for (folder, reason) in &self.folders {
            let Ok(entries) = std::fs::read_dir(folder) else {
                continue;
            };
            for path in entries.filter_map(|entry| Some(entry.ok()?.path())) {
                let Some(name) = plugin_name(&path) else { continue };
                if found.contains_key(&name) || !is_plugin_file(&path) {
                    continue;
                }
                found.insert(name.clone(), PluginFile { name, path, reason });
            }
        }
        found.into_values().collect()
    }
}

fn is_plugin_file(path: &Path) -> bool {
    jde_files::open(path).is_ok_and(|file| {
        elf::is_plugin(
            &elf::ElfFile::new(file),
            raw::ENTRY_SYMBOL,
            &raw::MAGIC.to_ne_bytes(),
        )
    })
}

fn file_name(plugin: &str) -> String {
    if python::is_python(plugin) {
        return plugin.to_owned();
    }
    format!(
        "{}{}{}",
        std::env::consts::DLL_PREFIX,
        plugin.replace('-', "_"),
        std::env::consts::DLL_SUFFIX
    )
}

fn plugin_name(path: &Path) -> Option<String> {
    let file = path.file_name()?.to_str()?;
    let name = file
        .strip_prefix(std::env::consts::DLL_PREFIX)?
        .strip_suffix(std::env::consts::DLL_SUFFIX)?;
    Some(name.to_owned())
}
