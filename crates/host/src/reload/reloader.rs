//! From the name of a schema or a plugin to builds that took over: reads the plugin's file anew, has everything checked before anything
//! is touched, and says for each schema what became of it.

use std::path::PathBuf;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use serde::{Deserialize, Serialize};

use super::{How, Takeover};
use crate::plugin::{Builds, LoadError, Loaded, PluginError, Plugins, Renewed};
use crate::running::Handle;

/// How long a schema may take to come to the end of its iteration before its answer is no longer waited for.
const TURN: Duration = Duration::from_secs(3);

/// Reloads the schemas of a running application. Usable from any thread; one reload at a time.
pub struct Reloader {
    handle: Handle,
    plugins: Arc<Plugins>,
    one_at_a_time: Mutex<()>,
}

/// What came of a reload.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Reloaded {
    /// The plugin's file.
    pub file: PathBuf,
    /// What became of each schema.
    pub schemas: Vec<(String, Became)>,
    /// What the process has in memory for reloads.
    pub memory: Builds,
}

/// What became of a schema that was to be reloaded.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Became {
    /// The new build took over.
    Reloaded(Takeover),
    /// It runs what is in the file already.
    Unchanged,
    /// It runs what is in the file already, but had faulted: it tries again, with a fresh instance and all its restarts.
    Restarted,
    /// The build before goes on; why.
    Undone(String),
    /// It is inside a call and takes over at the end of that.
    Waiting,
}

/// Why nothing was reloaded.
#[derive(Debug, thiserror::Error)]
pub enum Refused {
    /// Nothing has that name.
    #[error("there is no schema and no plugin `{name}` in the application")]
    Unknown {
        /// The name.
        name: String,
        /// The nearest there is.
        nearest: Option<String>,
    },
    /// It is part of the program.
    #[error("`{0}` is linked into the program, so there is no file to reload it from")]
    LinkedIn(String),
    /// The plugin cannot be used as it is now.
    #[error("{0}")]
    Plugin(#[from] PluginError),
    /// It does not fit the application.
    #[error("{}", list(.0))]
    Misfit(Vec<(String, Vec<String>)>),
}

impl Refused {
    /// The nearest name there is, if a name was not known.
    #[must_use]
    pub fn nearest(&self) -> Option<&str> {
        match self {
            Self::Unknown { nearest, .. } => nearest.as_deref(),
            Self::LinkedIn(_) | Self::Plugin(_) | Self::Misfit(_) => None,
        }
    }

    /// Whether the file may only be half there: it is being written, and will be whole later.
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
    /// Of an application, and the plugins that it was checked against.
    #[must_use]
    pub fn new(handle: Handle, plugins: Arc<Plugins>) -> Self {
        Self {
            handle,
            plugins,
            one_at_a_time: Mutex::new(()),
        }
    }

    /// The files of the application's plugins, each with the plugin's name.
    #[must_use]
    pub fn files(&self) -> Vec<(String, PathBuf)> {
        let plugins = self.handle.application().plugins.iter();
        let files = plugins.filter_map(|plugin| {
            let file = self.plugins.loaded(plugin)?.path?;
            Some((plugin.name.clone(), file))
        });
        files.collect()
    }

    /// Has the build that is now in a plugin's file take over, as `by`: for one schema by its name, or for all of a plugin by the
    /// plugin's. Waits until they had their turns; in lockstep that is another thread's business.
    ///
    /// # Errors
    /// [`Refused`]: nothing was touched then. What goes wrong later goes wrong for one schema, which then goes on with the build
    /// before: see [`Became`].
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
        // All are asked before any is waited for: they take their turns beside each other.
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
    /// Whether every schema runs what is in the file.
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

/// The schemas that a name means: one, or all of a plugin.
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

/// One line for a single reason, and one for each of several.
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
