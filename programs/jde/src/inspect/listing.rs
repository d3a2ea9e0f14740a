//! Lists the plugins, their folders, and the files there that cannot be used.

use std::collections::HashMap;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use jde_loader::{LoadError, PluginError, Plugins, SearchPath};
use jde_session::load::{PluginCatalogue, Purpose, Trust};
use jde_session::paths;
use jde_terminal::{BAD, FAINT, TITLE, WARN};
use serde::Serialize;

use crate::failure::{self, Failure};

/// The output of `jde plugins`.
#[derive(Serialize)]
pub(crate) struct PluginListing {
    folders: Vec<Folder>,
}

/// A searched folder, or what distributions of Python state. Folders are in the order of the search.
#[derive(Serialize)]
struct Folder {
    path: PathBuf,
    because: &'static str,
    exists: bool,
    plugins: Vec<PluginEntry>,
    unusable: Vec<UnusableFile>,
}

#[derive(Serialize)]
struct PluginEntry {
    name: String,
    version: String,
    schemas: Vec<String>,
    path: PathBuf,
    /// The file of the same name in an earlier folder, which has precedence.
    hidden_by: Option<PathBuf>,
}

#[derive(Serialize)]
struct UnusableFile {
    path: PathBuf,
    reason: String,
}

impl PluginListing {
    /// Looks into every folder that is searched, for one application or for all.
    ///
    /// # Errors
    /// There is no such application.
    pub(crate) fn scan(application: Option<&Path>) -> Result<Self, Failure> {
        let file = application.map(paths::find_application).transpose()?;
        let path = SearchPath::usual(file.as_deref());
        let catalogue = PluginCatalogue::new(path, Purpose::Describe, Trust::Trusted);
        let (plugins, named) = named_folders(file.as_deref(), catalogue)?;
        let mut path = SearchPath::default();
        for folder in named {
            path.push(folder, "named in the application");
        }
        for (folder, because) in plugins.search_path().folders() {
            path.push(folder, because);
        }
        let mut seen = HashMap::new();
        let folders = path
            .folders()
            .map(|(folder, because)| scan_folder(&plugins, folder, because, &mut seen));
        let mut folders: Vec<_> = folders.collect();
        let installed: Vec<_> = plugins.entry_points().into_iter().map(|(_, file)| file).collect();
        if !installed.is_empty() {
            let (group, because) = SearchPath::ENTRY_POINTS;
            folders.push(describe_files(
                &plugins,
                group.as_ref(),
                because,
                installed,
                &mut seen,
            ));
        }
        Ok(Self { folders })
    }

    /// Writes the list.
    ///
    /// # Errors
    /// The output cannot be written.
    pub(crate) fn write(&self, output: &mut dyn Write) -> io::Result<()> {
        for folder in &self.folders {
            let missing = if folder.exists { "" } else { ", missing" };
            let (shown, because) = (failure::display_path(&folder.path), folder.because);
            writeln!(
                output,
                "{TITLE}{shown}{TITLE:#}  {FAINT}({because}{missing}){FAINT:#}"
            )?;
            let width = folder
                .plugins
                .iter()
                .map(|plugin| plugin.name.len())
                .max()
                .unwrap_or(0);
            for PluginEntry {
                name,
                version,
                schemas,
                hidden_by,
                ..
            } in &folder.plugins
            {
                let schemas = schemas.join(", ");
                write!(output, "  {name:<width$}  {version}  {schemas}")?;
                if let Some(other) = hidden_by {
                    write!(
                        output,
                        "  {WARN}hidden by {}{WARN:#}",
                        failure::display_path(other)
                    )?;
                }
                writeln!(output)?;
            }
            for UnusableFile { path, reason } in &folder.unusable {
                writeln!(output, "  {BAD}{}{BAD:#}: {reason}", failure::display_path(path))?;
            }
        }
        Ok(())
    }
}

/// Returns the folders that an application names, even if it has faults.
fn named_folders(
    file: Option<&Path>,
    catalogue: PluginCatalogue,
) -> Result<(Plugins, Vec<PathBuf>), Failure> {
    if let Some(file) = file
        && let Err(faults) = jde_app::load(file, &[], &catalogue)
        && !file.is_file()
    {
        return Err(Failure::faults(faults));
    }
    let (plugins, report) = catalogue.into_parts();
    Ok((plugins, report.folders))
}

fn scan_folder(
    plugins: &Plugins,
    path: &Path,
    because: &'static str,
    seen: &mut HashMap<String, PathBuf>,
) -> Folder {
    let mut files: Vec<PathBuf> = std::fs::read_dir(path)
        .into_iter()
        .flatten()
        .filter_map(|entry| Some(entry.ok()?.path()))
        .filter(|file| is_library(file))
        .collect();
    files.sort();
    Folder {
        exists: path.is_dir(),
        ..describe_files(plugins, path, because, files, seen)
    }
}

fn describe_files(
    plugins: &Plugins,
    path: &Path,
    because: &'static str,
    files: Vec<PathBuf>,
    seen: &mut HashMap<String, PathBuf>,
) -> Folder {
    let mut folder = Folder {
        path: path.to_owned(),
        because,
        exists: true,
        plugins: Vec::new(),
        unusable: Vec::new(),
    };
    for file in files {
        match plugins.describe_file(&file) {
            Ok(plugin) => {
                let description = &plugin.description;
                let hidden_by = seen.get(&description.name).cloned();
                seen.entry(description.name.clone())
                    .or_insert_with(|| file.clone());
                folder.plugins.push(PluginEntry {
                    name: description.name.clone(),
                    version: description.version.clone(),
                    schemas: description
                        .schemas
                        .iter()
                        .map(|schema| schema.name.clone())
                        .collect(),
                    path: file,
                    hidden_by,
                });
            }
            // A build leaves libraries of every kind beside the executable.
            Err(PluginError::Unusable {
                error: LoadError::NotAPlugin,
                ..
            }) if because == SearchPath::BESIDE_THE_EXECUTABLE => {}
            Err(error) => {
                let reason =
                    std::error::Error::source(&error).map_or_else(|| error.to_string(), ToString::to_string);
                let file_name = format!("{}: ", file.display());
                folder.unusable.push(UnusableFile {
                    reason: reason.replace(&file_name, ""),
                    path: file,
                });
            }
        }
    }
    folder
}

fn is_library(file: &Path) -> bool {
    let name = file
        .file_name()
        .and_then(|name| name.to_str())
        .unwrap_or_default();
    name.starts_with(std::env::consts::DLL_PREFIX) && name.ends_with(std::env::consts::DLL_SUFFIX)
}
