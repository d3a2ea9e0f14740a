//! The plugins of one process, each loaded once: the catalogue against which application files are checked.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

use jde_abi::{describe, raw};

use crate::app::{Application, Catalogue, Instance};

use super::{Found, LoadError, Loaded, SearchPath};

/// Plugins by name; loads one when it is first asked for.
#[derive(Debug, Default)]
pub struct Plugins {
    path: SearchPath,
    loaded: Mutex<BTreeMap<PathBuf, Loaded>>,
    linked_in: BTreeMap<String, Loaded>,
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
        if let Some(plugin) = loaded.get(&key) {
            return Ok(plugin.clone());
        }
        let plugin = Loaded::open(&key).map_err(|error| PluginError::Unusable {
            path: file.to_owned(),
            error,
        })?;
        loaded.insert(key, plugin.clone());
        Ok(plugin)
    }

    /// The loaded plugin that this is the description of.
    pub(crate) fn loaded(&self, description: &Arc<describe::Plugin>) -> Option<Loaded> {
        let loaded = self.loaded.lock().unwrap_or_else(PoisonError::into_inner);
        let found = loaded
            .values()
            .chain(self.linked_in.values())
            .find(|plugin| Arc::ptr_eq(&plugin.description, description));
        found.cloned()
    }

    /// The schemas of an application that have a panel of their own, by their places; known before it starts, unlike
    /// [`Handle::panels`](crate::Handle::panels).
    #[must_use]
    pub fn panels(&self, application: &Application) -> Vec<usize> {
        let has_panel = |instance: &Instance| {
            let table = crate::running::table(application, self, instance);
            table.is_ok_and(|table| crate::instance::panel_of(table).is_some())
        };
        let instances = application.instances.iter().enumerate();
        instances
            .filter(|(_, instance)| has_panel(instance))
            .map(|(place, _)| place)
            .collect()
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
        let types = loaded.values().chain(self.linked_in.values()).flat_map(|plugin| {
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
