//! Reloads schemas by the name of a schema or a plugin: reads the plugin's file again, checks every schema
//! before any of them changes, and returns the result for each.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};

use jde_core::{Nanos, SchemaId};
use jde_loader::{LoadError, LoadedPlugin, PluginError, Plugins, RefreshedPlugin};
use jde_records::reload::{BuildName, ReloadOutcome, ReloadReport};
use parking_lot::Mutex;

use super::ReloadOptions;
use crate::running::Handle;

/// The longest wait for the outcome of one reload request: all its schemas together.
const RELOAD_TIMEOUT: Duration = Duration::from_secs(3);

/// Reloads the schemas of a running application. Usable from any thread; one reload runs at a time.
pub struct Reloader {
    handle: Handle,
    plugins: Arc<Plugins>,
    reload_lock: Mutex<()>,
}

/// Why nothing was reloaded.
#[derive(Debug, thiserror::Error)]
pub enum ReloadError {
    /// No schema or plugin has that name.
    #[error("there is no schema and no plugin `{name}` in the application")]
    Unknown {
        /// The name.
        name: String,
        /// The most similar known name.
        nearest: Option<String>,
    },
    /// The plugin is linked into the program.
    #[error("`{0}` is linked into the program, so there is no file to reload it from")]
    LinkedIn(String),
    /// The plugin's current file cannot be used.
    #[error("{0}")]
    Plugin(#[from] PluginError),
    /// The build does not fit the application; the reasons, by schema.
    #[error("{}", list(.0))]
    Incompatible(Vec<(String, Vec<String>)>),
}

impl ReloadError {
    /// Returns the most similar known name, if a name was unknown.
    #[must_use]
    pub fn nearest(&self) -> Option<&str> {
        match self {
            Self::Unknown { nearest, .. } => nearest.as_deref(),
            Self::LinkedIn(_) | Self::Plugin(_) | Self::Incompatible(_) => None,
        }
    }

    /// Whether the file may be incomplete because it is still being written.
    #[must_use]
    pub fn may_be_unfinished(&self) -> bool {
        matches!(
            self,
            Self::Plugin(PluginError::Unusable {
                error: LoadError::Io(_) | LoadError::Invalid(_),
                ..
            })
        )
    }
}

impl Reloader {
    /// Returns a reloader for an application, and the plugins against which it was checked.
    #[must_use]
    pub fn new(handle: Handle, plugins: Arc<Plugins>) -> Self {
        Self {
            handle,
            plugins,
            reload_lock: Mutex::new(()),
        }
    }

    /// Returns the files of the application's plugins, each with the plugin's place in
    /// [`Application::plugins`](jde_app::Application::plugins).
    #[must_use]
    pub fn files(&self) -> Vec<(usize, PathBuf)> {
        let plugins = self.handle.application().plugins.iter().enumerate();
        let files = plugins.filter_map(|(place, plugin)| Some((place, self.plugins.loaded(plugin)?.path?)));
        files.collect()
    }

    /// Lets the build that is now in a plugin's file take over, in the name of the operator `by`: for one
    /// schema by its name, or for all schemas of a plugin by the plugin's name. If a schema has the name of its plugin,
    /// the plugin is meant. Waits for their turns, at most 3 s. In lockstep, call it on another thread than the one that
    /// runs the application.
    ///
    /// # Errors
    /// [`ReloadError`]: no schema has changed then. A later failure concerns one schema, which continues with
    /// the previous build: see [`ReloadOutcome`].
    pub fn reload(&self, by: &str, name: &str, options: ReloadOptions) -> Result<ReloadReport, ReloadError> {
        self.reload_all(by, &find_schemas(&self.handle, name)?, options)
    }

    /// Like [`Self::reload`], for all schemas of the plugin at that place.
    ///
    /// # Errors
    /// As of [`Self::reload`].
    ///
    /// # Panics
    /// If there is no such plugin.
    pub fn reload_plugin(
        &self,
        by: &str,
        plugin: usize,
        options: ReloadOptions,
    ) -> Result<ReloadReport, ReloadError> {
        let instances = self.handle.application().instances.entries();
        let of_plugin = instances.filter(|(_, instance)| instance.plugin == plugin);
        let schemas: Vec<_> = of_plugin.map(|(id, _)| id).collect();
        self.reload_all(by, &schemas, options)
    }

    /// Reports as events that the schemas of the plugin at that place go on without its present file, for this reason.
    ///
    /// # Panics
    /// If there is no such plugin.
    pub fn report_failure(&self, plugin: usize, error: &ReloadError) {
        let application = self.handle.application();
        let loaded = self.plugins.loaded(&application.plugins[plugin]);
        let build = BuildName {
            version: String::new(),
            file: loaded.and_then(|loaded| loaded.path),
        };
        let reason = match error {
            // The build names the file.
            ReloadError::Plugin(PluginError::Unusable { error, .. }) => error.to_string(),
            other => other.to_string(),
        };
        let engine = &self.handle.engine;
        let instances = application.instances.entries();
        for (schema, _) in instances.filter(|(_, instance)| instance.plugin == plugin) {
            engine.report_reload_failure(schema, &build, &reason);
        }
    }

    /// Reloads schemas of one plugin, at least one.
    fn reload_all(
        &self,
        by: &str,
        schemas: &[SchemaId],
        options: ReloadOptions,
    ) -> Result<ReloadReport, ReloadError> {
        let _turn = self.reload_lock.lock();
        let application = self.handle.application();
        let first = &application.instances[schemas[0]];
        let plugin = &application.plugins[first.plugin];
        let loaded = self.plugins.loaded(plugin);
        let file = loaded
            .and_then(|loaded| loaded.path)
            .ok_or_else(|| ReloadError::LinkedIn(plugin.name.clone()))?;
        let RefreshedPlugin { plugin, .. } = self.plugins.refresh(&file)?;
        let schemas = self.replace(by, schemas, &plugin, options)?;
        Ok(ReloadReport {
            age: file_age(&file),
            file,
            schemas,
            memory: self.plugins.builds(),
        })
    }

    fn replace(
        &self,
        by: &str,
        schemas: &[SchemaId],
        plugin: &LoadedPlugin,
        options: ReloadOptions,
    ) -> Result<Vec<(String, ReloadOutcome)>, ReloadError> {
        let operator = self.handle.operator(by);
        let name = |schema: SchemaId| self.handle.application().instances[schema].name.clone();
        let changed = schemas
            .iter()
            .filter(|schema| !operator.is_running_build(**schema, plugin));
        let incompatible = changed.filter_map(|schema| {
            let reasons = operator.check_build(*schema, plugin).err()?;
            Some((name(*schema), reasons))
        });
        let incompatible: Vec<_> = incompatible.collect();
        if !incompatible.is_empty() {
            return Err(ReloadError::Incompatible(incompatible));
        }
        // All exchanges are requested before any is waited for, so that the schemas take their turns in
        // parallel.
        let reloads: Vec<_> = schemas
            .iter()
            .map(|schema| {
                let is_same = operator.is_running_build(*schema, plugin);
                let reload = (!is_same).then(|| operator.replace(*schema, plugin, options));
                (*schema, reload)
            })
            .collect();
        let end = Instant::now() + RELOAD_TIMEOUT;
        let outcomes = reloads.into_iter().map(|(schema, reload)| {
            let outcome = match reload {
                None if operator.is_faulted(schema) => operator
                    .load(schema)
                    .map_or_else(ReloadOutcome::Undone, |()| ReloadOutcome::Restarted),
                None => ReloadOutcome::Unchanged,
                Some(Err(reasons)) => ReloadOutcome::Undone(reasons.join("; ")),
                Some(Ok(reload)) => match reload.wait(end.saturating_duration_since(Instant::now())) {
                    Some(Ok(takeover)) => ReloadOutcome::Reloaded(takeover),
                    Some(Err(reason)) => ReloadOutcome::Undone(reason),
                    None => ReloadOutcome::Waiting,
                },
            };
            (name(schema), outcome)
        });
        Ok(outcomes.collect())
    }
}

/// Returns the schemas that a name denotes: one schema, or all of a plugin. A schema that has the name of its plugin
/// denotes all of it, since their code is in one file.
fn find_schemas(handle: &Handle, name: &str) -> Result<Vec<SchemaId>, ReloadError> {
    let schemas = handle.schemas_named(name);
    let application = handle.application();
    if let Some(first) = schemas.first() {
        let plugin = application.instances[*first].plugin;
        if application.plugins[plugin].name != name {
            return Ok(schemas);
        }
        let of_plugin = application.instances.entries();
        let of_plugin = of_plugin.filter(|(_, instance)| instance.plugin == plugin);
        return Ok(of_plugin.map(|(id, _)| id).collect());
    }
    let schemas = application
        .instances
        .iter()
        .map(|instance| instance.name.as_str());
    let plugins = application.plugins.iter().map(|plugin| plugin.name.as_str());
    Err(ReloadError::Unknown {
        nearest: jde_nearest::nearest(name, schemas.chain(plugins)).map(str::to_owned),
        name: name.to_owned(),
    })
}

/// Returns how long ago a file was written, ns.
fn file_age(file: &Path) -> Option<Nanos> {
    let written = file.metadata().and_then(|metadata| metadata.modified()).ok()?;
    Some(written.elapsed().unwrap_or_default().as_nanos() as Nanos)
}

/// Formats a single reason on one line, and several on a line each.
fn list(incompatible: &[(String, Vec<String>)]) -> String {
    let mut lines = Vec::new();
    for (schema, reasons) in incompatible {
        match &reasons[..] {
            [reason] => lines.push(format!("`{schema}` stays as it is: {reason}")),
            reasons => {
                lines.push(format!(
                    "`{schema}` stays as it is, for {} reasons:",
                    reasons.len()
                ));
                lines.extend(reasons.iter().map(|reason| format!("  {reason}")));
            }
        }
    }
    lines.join("\n")
}
