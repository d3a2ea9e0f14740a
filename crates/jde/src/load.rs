//! From the name of an application to one that is checked, and the plugins that belong to it. Starts nothing.

use std::cell::RefCell;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use jde_abi::describe;
use jde_host::app::{self, Application, Catalogue, Faults, Override};
use jde_host::plugin::{PluginError, Plugins, SearchPath};

use crate::failure::Failure;
use crate::places;

/// A checked application with its plugins.
pub(crate) struct Loaded {
    /// The application.
    pub(crate) application: Application,
    /// The plugins it was checked against.
    pub(crate) plugins: Plugins,
}

/// Plugins as an application's types are looked up in them, and what was noticed meanwhile.
pub(crate) struct Shelf<'p> {
    plugins: &'p Plugins,
    noticed: RefCell<Noticed>,
}

/// What was noticed while types were looked up.
#[derive(Default)]
pub(crate) struct Noticed {
    /// A plugin's file is there but cannot be used.
    pub(crate) unusable: bool,
    /// A plugin is not there.
    pub(crate) missing: bool,
    /// Folders that the application names.
    pub(crate) folders: Vec<PathBuf>,
}

/// Loads and checks an application, given as a file or by name.
///
/// # Errors
/// All that is wrong with it.
pub(crate) fn application(given: &Path, overrides: &[Override]) -> Result<Loaded, Failure> {
    let file = places::application(given)?;
    checked(&file, |file, shelf| app::load(file, overrides, shelf))
}

/// Checks the text of an application's file that stands there, or did.
///
/// # Errors
/// All that is wrong with it.
pub(crate) fn text(file: &Path, text: &str, overrides: &[Override]) -> Result<Loaded, Failure> {
    checked(file, |file, shelf| app::parse(text, file, overrides, shelf))
}

fn checked(
    file: &Path,
    check: impl FnOnce(&Path, &Shelf<'_>) -> Result<Application, Faults>,
) -> Result<Loaded, Failure> {
    let plugins = Plugins::new(SearchPath::usual(Some(file)));
    let shelf = Shelf::new(&plugins);
    match check(file, &shelf) {
        Ok(application) => Ok(Loaded { application, plugins }),
        Err(faults) => {
            let Noticed {
                unusable, missing, ..
            } = shelf.noticed();
            Err(Failure::Application {
                faults,
                unusable,
                missing,
            })
        }
    }
}

impl<'p> Shelf<'p> {
    /// The plugins to look in.
    pub(crate) fn new(plugins: &'p Plugins) -> Self {
        Self {
            plugins,
            noticed: RefCell::default(),
        }
    }

    /// What was noticed.
    pub(crate) fn noticed(self) -> Noticed {
        self.noticed.into_inner()
    }
}

impl Catalogue for Shelf<'_> {
    fn plugin(&self, name: &str, extra_dirs: &[PathBuf]) -> Result<Arc<describe::Plugin>, String> {
        self.noticed.borrow_mut().folders = extra_dirs.to_vec();
        match self.plugins.load(name, extra_dirs) {
            Ok(loaded) => Ok(loaded.description),
            Err(error) => {
                let missing = matches!(error, PluginError::Missing { .. });
                let mut noticed = self.noticed.borrow_mut();
                noticed.missing |= missing;
                noticed.unusable |= !missing;
                Err(error.to_string())
            }
        }
    }

    fn known(&self) -> Vec<String> {
        let (files, linked_in) = self.plugins.list(&self.noticed.borrow().folders);
        let opened = files.iter().filter_map(|file| self.plugins.open(&file.path).ok());
        let linked_in = linked_in
            .iter()
            .filter_map(|name| self.plugins.load(name, &[]).ok());
        let mut known = Vec::new();
        for plugin in linked_in.chain(opened) {
            let schemas = plugin.description.schemas.iter();
            known.extend(schemas.map(|schema| format!("{}/{}", plugin.description.name, schema.name)));
        }
        known
    }
}
