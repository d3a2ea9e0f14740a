//! Reloads schemas by the name of a schema or a plugin: reads the plugin's file again, checks every schema
//! before any of them changes, and returns the result for each.

use std::path::PathBuf;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use serde::{Deserialize, Serialize};

use super::{How, Takeover};
use crate::plugin::{Builds, LoadError, Loaded, PluginError, Plugins, Renewed};
use crate::running::Handle;

/// The longest wait for the outcome of one reload request: all its schemas together.
const TURN: Duration = Duration::from_secs(3);

/// Reloads the schemas of a running application. Usable from any thread; one reload runs at a time.
pub struct Reloader {
    handle: Handle,
    plugins: Arc<Plugins>,
    one_at_a_time: Mutex<()>,
}

/// The result of a reload.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Reloaded {
    /// The plugin's file.
    pub file: PathBuf,
    /// The result for each schema.
    pub schemas: Vec<(String, Became)>,
    /// The builds that the process keeps in memory because of reloads.
    pub memory: Builds,
}

/// The result for one schema.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Became {
    /// The new build took over.
    Reloaded(Takeover),
    /// It already runs the build in the file.
    Unchanged,
    /// It already runs the build in the file, but had faulted: it may start again, with a fresh instance and
    /// all its restarts.
    Restarted,
    /// The build before continues, for this reason.
    Undone(String),
    /// It is inside a call, and takes over when the call ends.
    Waiting,
}

/// Why nothing was reloaded.
#[derive(Debug, thiserror::Error)]
pub enum Refused {
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
    /// The plugin's present file cannot be used.
    #[error("{0}")]
    Plugin(#[from] PluginError),
    /// The build does not fit the application; the reasons, by schema.
    #[error("{}", list(.0))]
    Misfit(Vec<(String, Vec<String>)>),
}

impl Refused {
    /// Returns the most similar known name, if a name was unknown.
    #[must_use]
    pub fn nearest(&self) -> Option<&str> {
        match self {
            Self::Unknown { nearest, .. } => nearest.as_deref(),
            Self::LinkedIn(_) | Self::Plugin(_) | Self::Misfit(_) => None,
        }
    }

    /// Whether the file may be incomplete because it is still being written.
    #[must_use]
    pub fn may_be_unfinished(&self) -> bool {
        matches!(
            self,
            Self::Plugin(PluginError::Unusable {
                error: LoadError::Io(_) | LoadError::Foreign(_),
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
            one_at_a_time: Mutex::new(()),
        }
    }

    /// Returns the files of the application's plugins, each with the plugin's name.
    #[must_use]
    pub fn files(&self) -> Vec<(String, PathBuf)> {
        let plugins = self.handle.application().plugins.iter();
        let files = plugins.filter_map(|plugin| {
            let file = self.plugins.loaded(plugin)?.path?;
            Some((plugin.name.clone(), file))
        });
        files.collect()
    }

    /// Has the build that is now in a plugin's file take over, in the name of the operator `by`: for one
    /// schema by its name, or for all schemas of a plugin by the plugin's name. Waits for their turns, at
    /// most 3 s. In lockstep, call it on another thread than the one that runs the application.
    ///
    /// # Errors
    /// [`Refused`]: nothing has changed then. A later failure concerns one schema, which continues with the
    /// build before: see [`Became`].
    pub fn reload(&self, by: &str, name: &str, how: How) -> Result<Reloaded, Refused> {
        let _turn = self.one_at_a_time.lock().unwrap_or_else(PoisonError::into_inner);
        let schemas = places(&self.handle, name)?;
        let application = self.handle.application();
        let first = &application.instances[schemas[0]];
        let loaded = self.plugins.loaded(&application.plugins[first.plugin]);
        let file = loaded
            .and_then(|loaded| loaded.path)
            .ok_or_else(|| Refused::LinkedIn(name.to_owned()))?;
        let Renewed { plugin, .. } = self.plugins.renew(&file)?;
        let schemas = self.replace(by, &schemas, &plugin, how)?;
        Ok(Reloaded {
            file,
            schemas,
            memory: self.plugins.builds(),
        })
    }

    fn replace(
        &self,
        by: &str,
        schemas: &[usize],
        plugin: &Loaded,
        how: How,
    ) -> Result<Vec<(String, Became)>, Refused> {
        let operator = self.handle.operator(by);
        let name = |schema: usize| self.handle.application().instances[schema].name.clone();
        let others = schemas.iter().filter(|schema| !operator.runs(**schema, plugin));
        let misfits = others.filter_map(|schema| {
            let reasons = operator.fits(*schema, plugin).err()?;
            Some((name(*schema), reasons))
        });
        let misfits: Vec<_> = misfits.collect();
        if !misfits.is_empty() {
            return Err(Refused::Misfit(misfits));
        }
        // All exchanges are requested before any is waited for, so that the schemas take their turns in
        // parallel.
        let orders: Vec<_> = schemas
            .iter()
            .map(|schema| {
                let same = operator.runs(*schema, plugin);
                let order = (!same).then(|| operator.replace(*schema, plugin, how));
                (*schema, order)
            })
            .collect();
        let end = Instant::now() + TURN;
        let became = orders.into_iter().map(|(schema, order)| {
            let became = match order {
                None if operator.is_faulted(schema) => operator
                    .load(schema)
                    .map_or_else(Became::Undone, |()| Became::Restarted),
                None => Became::Unchanged,
                Some(Err(reasons)) => Became::Undone(reasons.join("; ")),
                Some(Ok(reload)) => match reload.wait(end.saturating_duration_since(Instant::now())) {
                    Some(Ok(takeover)) => Became::Reloaded(takeover),
                    Some(Err(reason)) => Became::Undone(reason),
                    None => Became::Waiting,
                },
            };
            (name(schema), became)
        });
        Ok(became.collect())
    }
}

impl Reloaded {
    /// Whether every schema runs the build in the file.
    #[must_use]
    pub fn is_done(&self) -> bool {
        let done = |became: &Became| {
            matches!(
                became,
                Became::Reloaded(_) | Became::Unchanged | Became::Restarted
            )
        };
        self.schemas.iter().all(|(_, became)| done(became))
    }
}

/// Returns the schemas that a name denotes: one schema, or all of a plugin.
fn places(handle: &Handle, name: &str) -> Result<Vec<usize>, Refused> {
    let places = handle.places(name);
    if !places.is_empty() {
        return Ok(places);
    }
    let application = handle.application();
    let schemas = application
        .instances
        .iter()
        .map(|instance| instance.name.as_str());
    let plugins = application.plugins.iter().map(|plugin| plugin.name.as_str());
    Err(Refused::Unknown {
        nearest: jde_board::nearest(name, schemas.chain(plugins)).map(str::to_owned),
        name: name.to_owned(),
    })
}

/// Formats a single reason on one line, and several on a line each.
fn list(misfits: &[(String, Vec<String>)]) -> String {
    let mut lines = Vec::new();
    for (schema, reasons) in misfits {
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
