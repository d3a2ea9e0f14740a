//! The plugins of one process, each build loaded once: the catalogue against which application files are
//! checked. It unloads no plugin.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use jde_abi::inspect::Problem;
use jde_abi::{describe, raw};
use jde_records::reload::ExtraBuilds;
use parking_lot::Mutex;

use jde_app::{Catalogue, Inspection, Unusable};

use super::copy::PrivateCopy;
use super::inspector::Inspect;
use super::load::table_symbol_size;
use super::python::is_python;
use super::{LoadError, LoadedPlugin, PluginFile, SearchPath, copy};

/// The most builds that one process loads in place of others. Each stays in memory, and its private copy on
/// disk. A plugin has 0.5 to 5 MB, so this is enough for a day of editing, and less than a robot's computer
/// can spare.
pub const MAX_BUILDS: usize = 256;

/// The most folders that a message lists.
const MAX_LISTED: usize = 12;

/// Plugins by name; each is loaded on first use.
#[derive(Debug, Default)]
pub struct Plugins {
    path: SearchPath,
    /// All builds of each file, the newest last.
    loaded: Mutex<BTreeMap<PathBuf, Vec<LoadedPlugin>>>,
    linked_in: BTreeMap<String, LoadedPlugin>,
    /// Files that are used in place of those along the path, by the plugin's name.
    replacements: BTreeMap<String, PathBuf>,
    /// Plugins that were only inspected.
    described: Mutex<BTreeMap<PathBuf, DescribedPlugin>>,
    inspector: Option<Box<dyn Inspect>>,
}

/// A plugin that was inspected, and is not necessarily loaded.
#[derive(Clone, Debug)]
pub struct DescribedPlugin {
    /// Its description of itself.
    pub description: Arc<describe::Plugin>,
    /// Its file; `None` if it is linked in.
    pub path: Option<PathBuf>,
}

/// The current content of a plugin's file.
#[derive(Clone, Debug)]
pub struct RefreshedPlugin {
    /// The plugin.
    pub plugin: LoadedPlugin,
    /// Whether it was loaded just now; otherwise an identical build was loaded before.
    pub is_new: bool,
}

/// Why a plugin cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum PluginError {
    /// No folder contains its file.
    #[error("there is no plugin `{name}` in{}", lines(folders))]
    Missing {
        /// The requested name.
        name: String,
        /// The folders searched.
        folders: Vec<String>,
    },
    /// Its file cannot be used.
    #[error("{}: {error}", path.display())]
    Unusable {
        /// The file.
        path: PathBuf,
        /// The reason.
        error: LoadError,
    },
    /// Its file contains a plugin of another name.
    #[error("{} holds the plugin `{found}`, not `{name}`: rename the file or the plugin", path.display())]
    NameMismatch {
        /// The file.
        path: PathBuf,
        /// The name in its table.
        found: String,
        /// The name of its file.
        name: String,
    },
    /// Too many builds have been loaded since the process started.
    #[error(
        "this process has loaded {MAX_BUILDS} builds in place of others, {} MB in all, and none of them can be unloaded: restart the application",
        bytes.div_ceil(1 << 20)
    )]
    TooMany {
        /// The total size of their files.
        bytes: u64,
    },
}

impl Plugins {
    /// Returns the plugins found along `path`.
    #[must_use]
    pub fn new(path: SearchPath) -> Self {
        Self {
            path,
            ..Self::default()
        }
    }

    /// Lets `inspector` inspect each file before this process maps it, so that a damaged library ends the
    /// inspecting process and not this one.
    #[must_use]
    pub fn with_inspector(mut self, inspector: impl Inspect + 'static) -> Self {
        self.inspector = Some(Box::new(inspector));
        self
    }

    /// Uses this file for the plugin of that name, whatever else the path contains.
    #[must_use]
    pub fn with_file(mut self, name: &str, file: &Path) -> Self {
        self.replacements.insert(name.to_owned(), file.to_owned());
        self
    }

    /// Ends the inspecting process, if there is one. It is started again when needed.
    pub fn stop_inspector(&self) {
        if let Some(inspector) = &self.inspector {
            inspector.stop();
        }
    }

    /// Adds a plugin that is linked into this program. It takes precedence over files of its name.
    ///
    /// # Errors
    /// Its tables are invalid.
    pub fn link(&mut self, table: &'static raw::Plugin) -> Result<(), LoadError> {
        let plugin = LoadedPlugin::linked_in(table)?;
        self.linked_in.insert(plugin.description.name.clone(), plugin);
        Ok(())
    }

    /// Loads the plugin of that name, searching the `extra` folders first.
    ///
    /// # Errors
    /// No folder contains it, or the first file found cannot be used.
    pub fn load(&self, name: &str, extra: &[PathBuf]) -> Result<LoadedPlugin, PluginError> {
        if let Some(plugin) = self.linked_in.get(name) {
            return Ok(plugin.clone());
        }
        let file = self.file(name, extra)?;
        let plugin = self.open(&file)?;
        check_name(name, &plugin.description, &file)?;
        Ok(plugin)
    }

    /// Returns the description of the plugin of that name, searched for as in [`Self::load`]. With an
    /// inspecting process ([`Self::with_inspector`]) this process maps nothing; otherwise the plugin is
    /// loaded.
    ///
    /// # Errors
    /// As [`Self::load`].
    pub fn describe(&self, name: &str, extra: &[PathBuf]) -> Result<DescribedPlugin, PluginError> {
        if let Some(plugin) = self.linked_in.get(name) {
            return Ok(plugin.clone().into());
        }
        let file = self.file(name, extra)?;
        let plugin = self.describe_file(&file)?;
        check_name(name, &plugin.description, &file)?;
        Ok(plugin)
    }

    /// Returns the description of the plugin in that file, as [`Self::describe`].
    ///
    /// # Errors
    /// [`PluginError::Unusable`].
    pub fn describe_file(&self, file: &Path) -> Result<DescribedPlugin, PluginError> {
        let Some(inspector) = &self.inspector else {
            return self.open(file).map(DescribedPlugin::from);
        };
        let key = file.canonicalize().unwrap_or_else(|_| file.to_owned());
        let mut described = self.described.lock();
        if let Some(plugin) = described.get(&key) {
            return Ok(plugin.clone());
        }
        let copy = copy::create(&key).map_err(unusable(file))?;
        let inspected = inspect_copy(&**inspector, copy.path(), &key).map_err(unusable(file))?;
        let plugin = DescribedPlugin {
            description: Arc::new(describe::Plugin {
                isolated: is_python(&key),
                ..inspected
            }),
            path: Some(key.clone()),
        };
        described.insert(key, plugin.clone());
        Ok(plugin)
    }

    /// Returns the file of the plugin of that name.
    fn file(&self, name: &str, extra: &[PathBuf]) -> Result<PathBuf, PluginError> {
        if let Some(file) = self.replacements.get(name) {
            return Ok(file.clone());
        }
        let path = self.search_path_with(extra);
        // Python is started only for a name that no folder has.
        let installed = || {
            let mut installed = self.entry_points().into_iter();
            installed.find_map(|(known, file)| (known == name).then_some(file))
        };
        path.find(name)
            .map(|found| found.path)
            .or_else(installed)
            .ok_or_else(|| PluginError::Missing {
                name: name.to_owned(),
                folders: path
                    .folders()
                    .chain([(SearchPath::ENTRY_POINTS.0.as_ref(), SearchPath::ENTRY_POINTS.1)])
                    .map(|(folder, reason)| format!("{} ({reason})", folder.display()))
                    .collect(),
            })
    }

    /// Returns the names and files of the plugins that distributions of Python state as entry points. Starts Python.
    #[must_use]
    pub fn entry_points(&self) -> Vec<(String, PathBuf)> {
        let inspector = self.inspector.as_deref();
        inspector.map(Inspect::entry_points).unwrap_or_default()
    }

    /// Returns the plugin in that file, loaded at most once.
    ///
    /// # Errors
    /// [`PluginError::Unusable`].
    pub fn open(&self, file: &Path) -> Result<LoadedPlugin, PluginError> {
        let key = file.canonicalize().unwrap_or_else(|_| file.to_owned());
        let mut loaded = self.loaded.lock();
        if let Some(plugin) = loaded.get(&key).and_then(|builds| builds.last()) {
            return Ok(plugin.clone());
        }
        let plugin = copy::create(&key)
            .and_then(|copy| {
                let inspected = self.inspect_copy(&key, &copy)?;
                load_copy(&key, copy, inspected)
            })
            .map_err(unusable(file))?;
        loaded.insert(key, vec![plugin.clone()]);
        Ok(plugin)
    }

    /// Inspects a copy before this process maps it, if there is an inspector.
    fn inspect_copy(&self, file: &Path, copy: &PrivateCopy) -> Result<Option<describe::Plugin>, LoadError> {
        let inspector = self.inspector.as_deref();
        inspector
            .map(|inspector| inspect_copy(inspector, copy.path(), file))
            .transpose()
    }

    /// Loads the current content of that file, in addition to the builds loaded from it before. A build that
    /// is already loaded is reused and takes no more memory.
    ///
    /// # Errors
    /// [`PluginError::Unusable`]; [`PluginError::TooMany`] after [`MAX_BUILDS`].
    pub fn refresh(&self, file: &Path) -> Result<RefreshedPlugin, PluginError> {
        let key = file.canonicalize().unwrap_or_else(|_| file.to_owned());
        let copy = copy::create(&key).map_err(unusable(file))?;
        let find_known = |loaded: &BTreeMap<PathBuf, Vec<LoadedPlugin>>| {
            let mut builds = loaded.get(&key).into_iter().flatten();
            let plugin = builds.find(|build| build.has_content_of(&copy))?.clone();
            Some(RefreshedPlugin {
                plugin,
                is_new: false,
            })
        };
        // The lock is not held during the inspection, so that other callers need not wait.
        if let Some(known) = find_known(&self.loaded.lock()) {
            return Ok(known);
        }
        let inspected = self.inspect_copy(&key, &copy);
        // The inspector would be idle until the next build.
        self.stop_inspector();
        let inspected = inspected.map_err(unusable(file))?;
        let mut loaded = self.loaded.lock();
        let ExtraBuilds { builds, bytes } = count_replacements(&loaded);
        if builds >= MAX_BUILDS {
            return Err(PluginError::TooMany { bytes });
        }
        let plugin = load_copy(&key, copy, inspected).map_err(unusable(file))?;
        loaded.entry(key).or_default().push(plugin.clone());
        Ok(RefreshedPlugin { plugin, is_new: true })
    }

    /// Returns the number and size of the builds that were loaded in place of others.
    #[must_use]
    pub fn builds(&self) -> ExtraBuilds {
        count_replacements(&self.loaded.lock())
    }

    /// Returns the loaded plugin that has this description.
    #[must_use]
    pub fn loaded(&self, description: &Arc<describe::Plugin>) -> Option<LoadedPlugin> {
        let loaded = self.loaded.lock();
        let found = loaded
            .values()
            .flatten()
            .chain(self.linked_in.values())
            .find(|plugin| Arc::ptr_eq(&plugin.description, description));
        found.cloned()
    }

    /// Returns the file of a loaded plugin; `None` if it is linked in or not loaded.
    #[must_use]
    pub fn file_of(&self, description: &Arc<describe::Plugin>) -> Option<PathBuf> {
        self.loaded(description)?.path
    }

    /// Returns the files along the search path that look like plugins, and the names of the linked-in
    /// plugins. Loads no file.
    #[must_use]
    pub fn list(&self, extra: &[PathBuf]) -> (Vec<PluginFile>, Vec<String>) {
        (
            self.search_path_with(extra).list(),
            self.linked_in.keys().cloned().collect(),
        )
    }

    /// Returns the folders searched, each with the reason.
    #[must_use]
    pub fn search_path(&self) -> &SearchPath {
        &self.path
    }

    fn search_path_with(&self, extra: &[PathBuf]) -> SearchPath {
        self.path.after(extra, "named in the application")
    }
}

impl Catalogue for Plugins {
    fn plugin(&self, name: &str, extra_dirs: &[PathBuf]) -> Result<Arc<describe::Plugin>, Unusable> {
        Ok(self.load(name, extra_dirs)?.description)
    }

    /// Runs in the inspecting process ([`Plugins::with_inspector`]). Without one, and for linked-in plugins,
    /// no problem is found.
    fn inspect(
        &self,
        plugin: &Arc<describe::Plugin>,
        inspection: &Inspection<'_>,
    ) -> Result<Vec<Problem>, String> {
        let Some(inspector) = &self.inspector else {
            return Ok(Vec::new());
        };
        let described = self.described.lock();
        let found = described
            .values()
            .find(|found| Arc::ptr_eq(&found.description, plugin));
        let described_path = found.and_then(|found| found.path.clone());
        drop(described);
        match described_path.or_else(|| self.file_of(plugin)) {
            Some(path) => inspector.inspect(&path, inspection),
            None => Ok(Vec::new()),
        }
    }

    /// Returns the names of all files that look like plugins, and the types of the loaded ones. No file is
    /// loaded for a suggestion.
    fn type_names(&self) -> Vec<String> {
        let (found, linked_in) = self.list(&[]);
        let loaded = self.loaded.lock();
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

impl From<PluginError> for Unusable {
    fn from(error: PluginError) -> Self {
        Self {
            reason: error.to_string(),
            is_missing: matches!(error, PluginError::Missing { .. }),
        }
    }
}

impl From<LoadedPlugin> for DescribedPlugin {
    fn from(plugin: LoadedPlugin) -> Self {
        Self {
            description: plugin.description,
            path: plugin.path,
        }
    }
}

/// Checks that a plugin has the name of its file. A file of Python, or an entry point, gives its plugin the name.
fn check_name(name: &str, description: &describe::Plugin, file: &Path) -> Result<(), PluginError> {
    if is_python(file) || description.name.replace('-', "_") == name.replace('-', "_") {
        return Ok(());
    }
    Err(PluginError::NameMismatch {
        path: file.to_owned(),
        found: description.name.clone(),
        name: name.to_owned(),
    })
}

/// Inspects the plugin in `copy`. This process has found the tables of a library in the file before.
fn inspect_copy(inspector: &dyn Inspect, copy: &Path, path: &Path) -> Result<describe::Plugin, LoadError> {
    if !is_python(path) {
        table_symbol_size(copy)?;
    }
    inspector.describe(copy, path)
}

/// Loads a copy of a file that was inspected, if there is an inspector.
fn load_copy(
    file: &Path,
    copy: PrivateCopy,
    inspected: Option<describe::Plugin>,
) -> Result<LoadedPlugin, LoadError> {
    match inspected {
        Some(inspected) if is_python(file) => LoadedPlugin::from_python(file, copy, &inspected),
        None if is_python(file) => Err(LoadError::Python(String::from(
            "only a program that inspects plugins in another process runs schemas in Python",
        ))),
        Some(_) | None => LoadedPlugin::from_copy(file, copy),
    }
}

/// Counts all builds except the first one of each file.
fn count_replacements(loaded: &BTreeMap<PathBuf, Vec<LoadedPlugin>>) -> ExtraBuilds {
    let replacements = loaded.values().flat_map(|builds| builds.iter().skip(1));
    replacements.fold(ExtraBuilds::default(), |sum, build| ExtraBuilds {
        builds: sum.builds + 1,
        bytes: sum.bytes + build.bytes(),
    })
}

/// Lists the folders that were searched, each on its line.
fn lines(folders: &[String]) -> String {
    let shown = folders.iter().take(MAX_LISTED);
    let mut lines: String = shown.map(|folder| format!("\n    {folder}")).collect();
    if let Some(more @ 1..) = folders.len().checked_sub(MAX_LISTED) {
        lines += &format!("\n    and {more} more");
    }
    lines
}

fn unusable(file: &Path) -> impl FnOnce(LoadError) -> PluginError {
    let path = file.to_owned();
    |error| PluginError::Unusable { path, error }
}
