//! Loads an application by name or file, checks it, and finds its plugins. Starts nothing.

use std::cell::RefCell;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use jde_abi::describe;
use jde_abi::inspect::Problem;
use jde_app::{Application, Catalogue, Fault, Faults, Inspection, Override, Unusable};
use jde_isolation::Inspector;
use jde_loader::python::is_python;
use jde_loader::{DescribedPlugin, Plugins, SearchPath};

use crate::failure::{self, Failure};
use crate::{child, paths};

/// A checked application with its plugins.
pub struct LoadedApplication {
    /// The application.
    pub application: Application,
    /// The plugins it was checked against.
    pub plugins: Plugins,
    /// Folders that its file names and that were not searched for plugins, because the file is not trusted.
    pub skipped_folders: Vec<PathBuf>,
}

/// The origin of an application's file.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Trust {
    /// The user named the file: plugins are searched for in the folders that it names, and beside it.
    Trusted,
    /// The file is part of a recording: plugins are searched for in the common folders only.
    Untrusted,
}

/// The catalogue of plugins for the check of one application. Collects what it notices during the look-ups.
pub struct PluginCatalogue {
    plugins: Plugins,
    purpose: Purpose,
    trust: Trust,
    /// Whether schemas inspect what their modulations name.
    inspects: bool,
    report: RefCell<LookupReport>,
}

/// The purpose of a look-up.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Purpose {
    /// Read the descriptions only. No plugin is loaded into this process.
    Describe,
    /// Load the plugins to run them.
    Run,
}

/// What the look-ups of types noticed.
#[derive(Default)]
pub struct LookupReport {
    /// Whether a plugin's file exists but cannot be used.
    pub unusable: bool,
    /// Whether a plugin does not exist.
    pub missing: bool,
    /// Folders that the application names.
    pub folders: Vec<PathBuf>,
    /// Folders that the application names and that were not searched.
    skipped_folders: Vec<PathBuf>,
}

/// Loads and checks an application that is to start, given as a file or by name. Prints a warning about
/// everything that is absent at present, and about each import that never has a value.
///
/// # Errors
/// All faults of the application.
pub fn load_to_start(given: &Path, overrides: &[Override]) -> Result<LoadedApplication, Failure> {
    let file = paths::find_application(given)?;
    let loaded = load(&file, overrides, PluginCatalogue::with_inspection)?;
    if let Some(concerns) = &loaded.application.concerns {
        failure::warn(concerns);
    }
    let absent = loaded.application.absent_imports();
    let absent: Vec<_> = absent.map(|warning| Fault::of_file(&file, warning)).collect();
    if !absent.is_empty() {
        failure::warn(&Faults::from(absent));
    }
    Ok(loaded)
}

/// Loads and checks an application whose drivers do not start, given as a file or by name.
///
/// # Errors
/// All faults of the application.
pub fn load_application(given: &Path, overrides: &[Override]) -> Result<LoadedApplication, Failure> {
    load(&paths::find_application(given)?, overrides, |catalogue| catalogue)
}

fn load(
    file: &Path,
    overrides: &[Override],
    with: impl FnOnce(PluginCatalogue) -> PluginCatalogue,
) -> Result<LoadedApplication, Failure> {
    let catalogue = PluginCatalogue::new(SearchPath::usual(Some(file)), Purpose::Run, Trust::Trusted);
    check_with(with(catalogue), |catalogue| {
        jde_app::load(file, overrides, catalogue)
    })
}

/// Checks an application, given as a file or by name, without loading any plugin into this process.
///
/// # Errors
/// All faults of the application.
pub fn check(given: &Path, overrides: &[Override]) -> Result<Application, Failure> {
    let file = paths::find_application(given)?;
    let catalogue = PluginCatalogue::new(SearchPath::usual(Some(&file)), Purpose::Describe, Trust::Trusted)
        .with_inspection();
    let loaded = check_with(catalogue, |catalogue| jde_app::load(&file, overrides, catalogue))?;
    Ok(loaded.application)
}

/// The plugins along a path. Their files are inspected in a child process, so a damaged file cannot end this
/// one.
pub fn plugins(path: SearchPath) -> Plugins {
    Plugins::new(path).with_inspector(Inspector::new(child::inspector()))
}

/// Describes every usable plugin that is linked in, along the search path or in more folders.
pub fn describe_all(plugins: &Plugins, extra: &[PathBuf]) -> Vec<DescribedPlugin> {
    let (files, linked_in) = plugins.list(extra);
    let linked_in = linked_in.iter().map(|name| plugins.describe(name, &[]));
    let found = files.iter().map(|file| plugins.describe_file(&file.path));
    linked_in.chain(found).filter_map(Result::ok).collect()
}

/// Checks the text of an application's file that a recording contains, with the file's name and its folder, if that exists
/// on this machine.
///
/// # Errors
/// All faults of the application.
pub fn load_attached(
    name: &str,
    text: &str,
    folder: Option<&Path>,
    overrides: &[Override],
    trust: Trust,
) -> Result<LoadedApplication, Failure> {
    let original = folder.map(|folder| folder.join(name));
    let path = SearchPath::usual(original.as_deref().filter(|_| trust == Trust::Trusted));
    let mut catalogue = PluginCatalogue::new(path, Purpose::Run, trust);
    if let (Some(folder), Trust::Untrusted) = (folder, trust) {
        let beside = [folder.to_owned(), folder.join("plugins")];
        catalogue.report.get_mut().skipped_folders.extend(beside);
    }
    let file = original.unwrap_or_else(|| name.into());
    check_with(catalogue, |catalogue| {
        jde_app::parse(text, &file, overrides, catalogue)
    })
}

fn check_with(
    catalogue: PluginCatalogue,
    check: impl FnOnce(&PluginCatalogue) -> Result<Application, Faults>,
) -> Result<LoadedApplication, Failure> {
    let checked = check(&catalogue);
    catalogue.plugins.stop_inspector();
    let (plugins, report) = catalogue.into_parts();
    let LookupReport {
        unusable,
        missing,
        skipped_folders: skipped,
        ..
    } = report;
    match checked {
        Ok(application) => Ok(LoadedApplication {
            application,
            plugins,
            skipped_folders: skipped,
        }),
        Err(faults) => Err(Failure::Application {
            faults,
            unusable,
            missing,
            skipped_folders: skipped,
        }),
    }
}

impl PluginCatalogue {
    /// Returns a catalogue of the plugins along a path.
    pub fn new(path: SearchPath, purpose: Purpose, trust: Trust) -> Self {
        Self {
            plugins: plugins(path),
            purpose,
            trust,
            inspects: false,
            report: RefCell::default(),
        }
    }

    /// Makes schemas inspect what their modulations name. Only for an application that starts, or for its
    /// check.
    fn with_inspection(self) -> Self {
        Self {
            inspects: true,
            ..self
        }
    }

    /// Returns those folders named by the application that are to be searched.
    fn searchable_folders<'d>(&self, named: &'d [PathBuf]) -> &'d [PathBuf] {
        let mut report = self.report.borrow_mut();
        match self.trust {
            Trust::Trusted => {
                report.folders = named.to_vec();
                named
            }
            Trust::Untrusted => {
                for folder in named {
                    if !report.skipped_folders.contains(folder) {
                        report.skipped_folders.push(folder.clone());
                    }
                }
                &[]
            }
        }
    }

    /// Returns the plugins and what was noticed.
    pub fn into_parts(self) -> (Plugins, LookupReport) {
        (self.plugins, self.report.into_inner())
    }
}

impl Catalogue for PluginCatalogue {
    fn plugin(&self, name: &str, extra_dirs: &[PathBuf]) -> Result<Arc<describe::Plugin>, Unusable> {
        let extra_dirs = self.searchable_folders(extra_dirs);
        let found = match self.purpose {
            Purpose::Describe => self.plugins.describe(name, extra_dirs),
            Purpose::Run => self.plugins.load(name, extra_dirs).map(DescribedPlugin::from),
        };
        match found {
            Ok(found) => Ok(found.description),
            Err(error) => {
                let error = Unusable::from(error);
                let mut report = self.report.borrow_mut();
                // Nothing builds a file of Python.
                report.missing |= error.is_missing && !is_python(name);
                report.unusable |= !error.is_missing;
                Err(error)
            }
        }
    }

    fn inspect(
        &self,
        plugin: &Arc<describe::Plugin>,
        inspection: &Inspection<'_>,
    ) -> Result<Vec<Problem>, String> {
        match self.inspects {
            true => self.plugins.inspect(plugin, inspection),
            false => Ok(Vec::new()),
        }
    }

    fn type_names(&self) -> Vec<String> {
        let folders = &self.report.borrow().folders;
        let (files, _) = self.plugins.list(folders);
        let mut known: Vec<_> = files.into_iter().map(|file| file.name).collect();
        let searched = self.plugins.search_path().folders().map(|(folder, _)| folder);
        known.extend(
            searched
                .chain(folders.iter().map(PathBuf::as_path))
                .flat_map(files_of_python),
        );
        for plugin in describe_all(&self.plugins, folders) {
            let schemas = plugin.description.schemas.iter();
            known.extend(schemas.map(|schema| format!("{}/{}", plugin.description.name, schema.name)));
        }
        known
    }
}

/// Returns the names of the files of Python in a folder.
fn files_of_python(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    let names = entries.filter_map(|entry| entry.file_name().into_string().ok());
    names.filter(|name| is_python(name)).collect()
}
