//! The plugins of one process, each build of one loaded once: the catalogue against which application files are checked.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

use jde_abi::{describe, raw};
use serde::{Deserialize, Serialize};

use crate::app::Catalogue;

use super::{Found, LoadError, Loaded, SearchPath, copy};

/// Most builds that one process loads in place of others. Each stays in memory, and so does its private copy on disk: at the
/// 0.5 to 5 MB of a plugin this is what a day of editing takes, and less than a machine that runs robots can miss.
pub const MOST_BUILDS: usize = 256;

/// Plugins by name; loads one when it is first asked for.
#[derive(Debug, Default)]
pub struct Plugins {
    path: SearchPath,
    /// All builds of each file, the newest last.
    loaded: Mutex<BTreeMap<PathBuf, Vec<Loaded>>>,
    linked_in: BTreeMap<String, Loaded>,
}

/// What a plugin's file holds now.
#[derive(Clone, Debug)]
pub struct Renewed {
    /// It.
    pub plugin: Loaded,
    /// It was loaded just now; otherwise the file has the content of a build that was loaded before.
    pub fresh: bool,
}

/// Builds in memory beside the first of each plugin: they are never unmapped.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Builds {
    /// How many.
    pub builds: usize,
    /// Bytes of their files.
    pub bytes: u64,
}

/// Why a plugin cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum PluginError {
    /// No folder has its file.
    #[error("there is no plugin `{name}` in {}", folders.join(", "))]
    Missing {
        /// The name asked for.
        name: String,
        /// The folders searched.
        folders: Vec<String>,
    },
    /// Its file cannot be used.
    #[error("{}: {error}", path.display())]
    Unusable {
        /// The file.
        path: PathBuf,
        /// Why.
        error: LoadError,
    },
    /// Its file holds a plugin of another name.
    #[error("{} holds the plugin `{found}`, not `{name}`: rename the file or the plugin", path.display())]
    OtherName {
        /// The file.
        path: PathBuf,
        /// The name in its table.
        found: String,
        /// The name of its file.
        name: String,
    },
    /// Too many builds were loaded since the process began.
    #[error(
        "this process has loaded {MOST_BUILDS} builds in place of others, {} MB in all, and none of them can leave its memory: start the application anew",
        bytes.div_ceil(1 << 20)
    )]
    TooMany {
        /// Bytes of their files.
        bytes: u64,
    },
}

impl Plugins {
    /// Plugins found along `path`.
    #[must_use]
    pub fn new(path: SearchPath) -> Self {
        Self {
            path,
            ..Self::default()
        }
    }

    /// Adds a plugin that is linked into this program; it comes before any file of its name.
    ///
    /// # Errors
    /// When its tables are wrong.
    pub fn link(&mut self, table: &'static raw::Plugin) -> Result<(), LoadError> {
        let plugin = Loaded::linked_in(table)?;
        self.linked_in.insert(plugin.description.name.clone(), plugin);
        Ok(())
    }

    /// The plugin of that name, looked for in `extra` folders first.
    ///
    /// # Errors
    /// When no folder has it, or the first that has it holds a file that cannot be used.
    pub fn load(&self, name: &str, extra: &[PathBuf]) -> Result<Loaded, PluginError> {
        if let Some(plugin) = self.linked_in.get(name) {
            return Ok(plugin.clone());
        }
        let path = self.path_with(extra);
        let Some(Found { path: file, .. }) = path.find(name) else {
            let folders = path
                .folders()
                .map(|(folder, because)| format!("{} ({because})", folder.display()))
                .collect();
            return Err(PluginError::Missing {
                name: name.to_owned(),
                folders,
            });
        };
        let plugin = self.open(&file)?;
        let found = &plugin.description.name;
        if found.replace('-', "_") != name.replace('-', "_") {
            return Err(PluginError::OtherName {
                path: file,
                found: found.clone(),
                name: name.to_owned(),
            });
        }
        Ok(plugin)
    }

    /// The plugin in that file, loaded at most once.
    ///
    /// # Errors
    /// [`PluginError::Unusable`].
    pub fn open(&self, file: &Path) -> Result<Loaded, PluginError> {
        let key = file.canonicalize().unwrap_or_else(|_| file.to_owned());
        let mut loaded = self.loaded.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(plugin) = loaded.get(&key).and_then(|builds| builds.last()) {
            return Ok(plugin.clone());
        }
        let plugin = Loaded::open(&key).map_err(unusable(file))?;
        loaded.insert(key, vec![plugin.clone()]);
        Ok(plugin)
    }

    /// The plugin in that file as it is now, beside those that were in it before. A build is loaded once: a file with the content of
    /// one that is there already takes no more memory.
    ///
    /// # Errors
    /// [`PluginError::Unusable`]; [`PluginError::TooMany`] after [`MOST_BUILDS`].
    pub fn renew(&self, file: &Path) -> Result<Renewed, PluginError> {
        let key = file.canonicalize().unwrap_or_else(|_| file.to_owned());
        let copy = copy::of(&key).map_err(unusable(file))?;
        let mut loaded = self.loaded.lock().unwrap_or_else(PoisonError::into_inner);
        let known = loaded
            .get(&key)
            .into_iter()
            .flatten()
            .find(|build| build.is(&copy));
        if let Some(plugin) = known {
            return Ok(Renewed {
                plugin: plugin.clone(),
                fresh: false,
            });
        }
        let Builds { builds, bytes: all } = replacements(&loaded);
        if builds >= MOST_BUILDS {
            return Err(PluginError::TooMany { bytes: all });
        }
        let plugin = Loaded::of(&key, copy).map_err(unusable(file))?;
        loaded.entry(key).or_default().push(plugin.clone());
        Ok(Renewed { plugin, fresh: true })
    }

    /// The builds that were loaded in place of others.
    #[must_use]
    pub fn builds(&self) -> Builds {
        replacements(&self.loaded.lock().unwrap_or_else(PoisonError::into_inner))
    }

    /// The loaded plugin that this is the description of.
    pub(crate) fn loaded(&self, description: &Arc<describe::Plugin>) -> Option<Loaded> {
        let loaded = self.loaded.lock().unwrap_or_else(PoisonError::into_inner);
        let found = loaded
            .values()
            .flatten()
            .chain(self.linked_in.values())
            .find(|plugin| Arc::ptr_eq(&plugin.description, description));
        found.cloned()
    }

    /// All there is along the search path and linked in, without loading any file.
    #[must_use]
    pub fn list(&self, extra: &[PathBuf]) -> (Vec<Found>, Vec<String>) {
        (
            self.path_with(extra).list(),
            self.linked_in.keys().cloned().collect(),
        )
    }

    /// The folders searched, each with the reason.
    #[must_use]
    pub fn search_path(&self) -> &SearchPath {
        &self.path
    }

    fn path_with(&self, extra: &[PathBuf]) -> SearchPath {
        let mut path = SearchPath::default();
        for folder in extra {
            path.push(folder, "named in the application");
        }
        for (folder, because) in self.path.folders() {
            path.push(folder, because);
        }
        path
    }
}

impl Catalogue for Plugins {
    fn plugin(&self, name: &str, extra_dirs: &[PathBuf]) -> Result<Arc<describe::Plugin>, String> {
        self.load(name, extra_dirs)
            .map(|plugin| plugin.description)
            .map_err(|error| error.to_string())
    }

    /// The names of all files that are plugins by their looks, and the types of those that are loaded: a suggestion is no reason
    /// to run anybody's code.
    fn known(&self) -> Vec<String> {
        let (found, linked_in) = self.list(&[]);
        let loaded = self.loaded.lock().unwrap_or_else(PoisonError::into_inner);
        let newest = loaded.values().filter_map(|builds| builds.last());
        let types = newest.chain(self.linked_in.values()).flat_map(|plugin| {
            let plugin = &plugin.description;
            plugin
                .schemas
                .iter()
                .map(|schema| format!("{}/{}", plugin.name, schema.name))
                .collect::<Vec<_>>()
        });
        let files = found.into_iter().map(|found| found.name).chain(linked_in);
        files.chain(types).collect()
    }
}

/// All but the first of each file.
fn replacements(loaded: &BTreeMap<PathBuf, Vec<Loaded>>) -> Builds {
    let replacements = loaded.values().flat_map(|builds| builds.iter().skip(1));
    replacements.fold(Builds::default(), |sum, build| Builds {
        builds: sum.builds + 1,
        bytes: sum.bytes + build.bytes(),
    })
}

fn unusable(file: &Path) -> impl FnOnce(LoadError) -> PluginError {
    let path = file.to_owned();
    |error| PluginError::Unusable { path, error }
}
